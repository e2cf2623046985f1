// The faces that get new samples in a frame. QUEUE_ACCESS is empty where the shader writes it.
#ifndef QUEUE_ACCESS
#define QUEUE_ACCESS readonly
#endif

layout(std430) QUEUE_ACCESS buffer Queue {
    uint count;     // faces that are listed
    uint work;      // paths in all
    uint per_face;  // paths for each
    uint seen;      // faces that are in sight
    uint every;     // of the faces in sight, one of so many is listed, in turn
} queue;
