// The lists of known_lamps.glsl, and what a frame adds to them. KNOWN_ACCESS is empty where the shader writes the lists.
#ifndef FACE_CACHE_KNOWN_GLSL
#define FACE_CACHE_KNOWN_GLSL
#ifndef KNOWN_ACCESS
#define KNOWN_ACCESS readonly
#endif

const uint KNOWN_CELLS = 32768u, KNOWN_EACH = 16u;

layout(std430) buffer Known {
    KNOWN_ACCESS uvec4 known[KNOWN_CELLS * KNOWN_EACH / 4u];   // four words of a list
    uint found[KNOWN_CELLS * KNOWN_EACH];                      // what this frame adds
};

#endif
