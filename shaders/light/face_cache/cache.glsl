// The cache: a table of faces and what it keeps of each slot, in one buffer, because a device need not bind more than eight. CACHE_ACCESS is empty where
// the shader writes it. UNSOFTENED leaves out what soften.comp needs. graphs/light/face_cache.toml has the size of the buffer.
#ifndef FACE_CACHE_CACHE_GLSL
#define FACE_CACHE_CACHE_GLSL
#ifndef CACHE_ACCESS
#define CACHE_ACCESS readonly
#endif

#include <raxel/light/face_slots.glsl>
#include "fit.glsl"

layout(std430) CACHE_ACCESS buffer Cache {
    Fit fit;
    uint face_keys[RX_FACE_SLOTS];
    uint asked[RX_FACE_SLOTS];        // frame in which the face was last asked for, from 1 on; 0 in a free slot
    uint generation[RX_FACE_SLOTS];   // of its light: state.generation of change.glsl
    vec4 light[RX_FACE_SLOTS];        // irradiance / pi, without direct sun; samples
    uint moves_seen[RX_FACE_SLOTS];   // moves.glsl
#ifndef UNSOFTENED
    float squares[RX_FACE_SLOTS];     // mean square of the samples' luminance
    uvec2 soft[RX_FACE_SLOTS];        // the light that the face shows, with less noise (soft.glsl)
#endif
};

#include <raxel/light/face_table.glsl>

#endif
