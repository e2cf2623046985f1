// The faces that get new samples in a frame. QUEUE_ACCESS is empty where the shader writes it.
#ifndef FACE_CACHE_QUEUE_GLSL
#define FACE_CACHE_QUEUE_GLSL
#ifndef QUEUE_ACCESS
#define QUEUE_ACCESS readonly
#endif

#include <raxel/light/face_slots.glsl>

// Sums are of whole numbers, so that their order does not matter.
const float QUEUE_ONE = 256.0, QUEUE_LOG_LEAST = -24.0, QUEUE_LOG_MOST = 24.0;

layout(std430) QUEUE_ACCESS buffer Queue {
    uint count;     // faces that are listed
    uint work;      // paths in all
    uint per_face;  // paths for each
    uint seen;      // faces that are in sight
    uint every;     // one of `every` faces in sight is listed, in turn
    uint spread;    // the sum over faces of the variance of a sample, relative to the shown light there
    uint spreads;   // how many faces that is
    uint logs;      // the sum of the logarithms of all light that falls on the shown places
    uint showing;   // how many pixels that is
    float bright;   // the mean of that light, in earlier frames; 0 as long as it is unknown
    float noise;    // the mean of the variances, in earlier frames; 0 as long as it is unknown
    uint lamps;     // how many the world has
    uint lost;      // pixels whose face found no slot in the table (warned of); of the hash cache, samples whose cell found none
    uint faces[RX_FACE_SLOTS];   // the slots of the listed faces, each once
    uint pick[];    // of each slot that is a cell of many faces, the pixel that stands for it in this frame (pick.glsl); 0 between frames
} queue;

// Whether samples are known to have little noise.
bool queue_quiet() {
    return queue.noise > 0.0 && queue.noise < 0.25;
}

// Whether only sun and sky give light. A lamp close to a path would make single samples bright enough to show as speckles.
bool queue_even() {
    return queue.lamps == 0u;
}

// Faces below this width in pixels show their own light, and share noise with no others. In a picture averaged over frames (JITTER), a pixel
// sees another narrow face in each frame. So the average shares their noise, except for speckles.
float queue_narrow() {
#ifdef JITTER
    return queue_even() ? 1.5 : 0.0;
#else
    return 0.0;
#endif
}

#endif
