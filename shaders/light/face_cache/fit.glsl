// Fits a view into the table of faces: `fit`, which cache.glsl declares.
#ifndef FACE_CACHE_FIT_GLSL
#define FACE_CACHE_FIT_GLSL

#include <raxel/light/face_slots.glsl>

// Widths of faces on the picture, in steps of a quarter octave from 2^-12 pixels on.
const uint FIT_BINS = 72u;
const float FIT_LEAST = -12.0, FIT_STEP = 0.25;
const uint FIT_APART = 64u;   // pixels for each one that is asked how wide its face is

struct Fit {
    ivec3 cell;      // the camera of the last frame, and the number of its pixels
    uint pixels;
    vec3 frac;
    float tangent;   // of half its field of view
    vec3 forward;
    uint used;       // slots that are taken
    uint pressure;   // 0 while most of the table is free, up to 3
    float grain;     // pixels across a cell, at least: smaller faces share one; below 0 where there are no cells
    float expected;  // slots that the view should take by the widths of its faces, 0 where any view fits
    float crowding;  // how many times more it took, in earlier frames
    uint chosen;     // the index of that grain in the choices of forget.comp
    uint bins[2u * FIT_BINS];   // pixels of the last frame by the width of their faces; then the pixels that gauge.comp has asked
};

// Slots for the faces in sight. The previous view may have as many for a frame, and the table then is no more than 60 % full, so all keys
// find one.
#define FIT_ROOM (RX_FACE_SLOTS / 32u * 9u)

uint fit_bin(float width) {
    return uint(clamp((log2(max(width, 1e-9)) - FIT_LEAST) / FIT_STEP, 0.0, float(FIT_BINS - 1u)));
}

float fit_width(uint bin) {
    return exp2(FIT_LEAST + FIT_STEP * (float(bin) + 0.5));
}

#endif
