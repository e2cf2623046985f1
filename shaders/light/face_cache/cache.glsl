// The cache: a table of faces and the data of each slot. They are one buffer, because a device need not bind more than eight.
// graphs/light/face_cache.toml has its size. CACHE_ACCESS is empty if the shader writes the cache, and SOFT_ACCESS is `writeonly` if it writes
// only `soft`: a buffer is faster if the shader only reads it. UNSOFTENED leaves out the data of soften.comp.
#ifndef FACE_CACHE_CACHE_GLSL
#define FACE_CACHE_CACHE_GLSL
#ifndef CACHE_ACCESS
#define CACHE_ACCESS readonly
#endif
#ifndef SOFT_ACCESS
#define SOFT_ACCESS readonly
#endif

#include <raxel/light/face_slots.glsl>
#include "fit.glsl"

layout(std430) buffer Cache {
    CACHE_ACCESS Fit fit;
    CACHE_ACCESS uint face_keys[RX_FACE_SLOTS];
    CACHE_ACCESS uint asked[RX_FACE_SLOTS];        // last frame with a request for the face, from 1 on; 0 in a free slot
    CACHE_ACCESS uint generation[RX_FACE_SLOTS];   // of its light: state.generation of change.glsl
    CACHE_ACCESS vec4 light[RX_FACE_SLOTS];        // irradiance / pi, without direct sun; samples
    CACHE_ACCESS uint moves_seen[RX_FACE_SLOTS];   // moves.glsl
#ifndef UNSOFTENED
    CACHE_ACCESS float squares[RX_FACE_SLOTS];     // mean square of the samples' luminance
    SOFT_ACCESS uvec2 soft[RX_FACE_SLOTS];         // the light that the face shows, with less noise (soft.glsl)
#endif
};

#include <raxel/light/face_table.glsl>

#endif
