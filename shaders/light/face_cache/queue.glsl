// The faces that get new samples in a frame. A face that is wide on the picture has several entries of the list, one after the other, and
// each entry is a new sample. QUEUE_ACCESS is empty where the shader writes it.
#ifndef FACE_CACHE_QUEUE_GLSL
#define FACE_CACHE_QUEUE_GLSL
#ifndef QUEUE_ACCESS
#define QUEUE_ACCESS readonly
#endif

#include <raxel/light/face_slots.glsl>

// Sums are of whole numbers, so that their order does not matter.
const float QUEUE_ONE = 256.0, QUEUE_LOG_LEAST = -24.0, QUEUE_LOG_MOST = 24.0;

layout(std430) QUEUE_ACCESS buffer Queue {
    uint count;     // entries of the list
    uint work;      // threads of a pass that has several for each entry
    uint wanted;    // entries that all faces in sight would have, with one for each pixel of their width
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
    float per_width;      // entries of a face for each pixel of its width
    float per_new_width;  // the same of faces that know no light: all of them fit into the list at once
    uint faces[RX_FACE_SLOTS];   // queue_entry
    uint pick[];    // of each slot that is a cell of many faces, the pixel that stands for it in this frame (pick.glsl); 0 between frames
} queue;

// An entry of the list: the slot of the face, the number of the entry among those of the face, how many these are, up to 16, and whether old
// samples of the face hardly count.
uint queue_entry(uint slot, uint number, uint of, bool late) {
    return slot | number << 20 | of - 1u << 24 | (late ? 1u << 28 : 0u);
}

const float LATE_SAMPLES = 8.0;   // old samples of a late face that count in any case

bool entry_is_late(uint entry) {
    return (entry >> 28 & 1u) != 0u;
}

uint entry_slot(uint entry) {
    return entry & RX_FACE_SLOTS - 1u;
}

uint entry_number(uint entry) {
    return entry >> 20 & 15u;
}

uint entries_of_face(uint entry) {
    return (entry >> 24 & 15u) + 1u;
}

// How many entries fit, for a picture of a size.
uint queue_room(ivec2 size) {
    return min(RX_FACE_SLOTS, 2u * uint(size.x * size.y));
}

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
