// The faces that get new samples in a frame. QUEUE_ACCESS is empty where the shader writes it.
#ifndef QUEUE_ACCESS
#define QUEUE_ACCESS readonly
#endif

// Sums are of whole numbers, so that their order does not matter.
const float QUEUE_ONE = 256.0, QUEUE_LOG_LEAST = -24.0, QUEUE_LOG_MOST = 24.0;

layout(std430) QUEUE_ACCESS buffer Queue {
    uint count;     // faces that are listed
    uint work;      // paths in all
    uint per_face;  // paths for each
    uint seen;      // faces that are in sight
    uint every;     // of the faces in sight, one of so many is listed, in turn
    uint spread;    // the sum of the variances of samples over faces, relative to what such a place shows
    uint spreads;   // how many faces that is
    uint logs;      // the sum of the logarithms of all light that falls on what pixels show
    uint showing;   // how many pixels that is
    float bright;   // the mean of that light, in earlier frames; 0 as long as nobody knows
    float noise;    // the mean of the variances, in earlier frames; 0 as long as nobody knows
} queue;
