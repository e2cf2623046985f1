// The lists of known_lamps.glsl, and what a frame adds to them.
#ifndef FACE_CACHE_KNOWN_GLSL
#define FACE_CACHE_KNOWN_GLSL

const uint KNOWN_CELLS = 32768u, KNOWN_EACH = 16u;

layout(std430) buffer Known {
    uvec4 known[KNOWN_CELLS * KNOWN_EACH / 4u];   // four words of a list
    uint found[KNOWN_CELLS * KNOWN_EACH];         // what this frame adds
};

#endif
