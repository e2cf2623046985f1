// Stores the new texels, when all faces have read the old ones.
#version 460
#include <raxel/thread.glsl>
layout(local_size_x = 64) in;
#include "light/face_cache/queue.glsl"
layout(std430) readonly buffer Fresh { uint fresh[]; };
#define CACHE_ACCESS
#include "light/face_cache/cache.glsl"
#define TEXEL_ACCESS
#include "texels.glsl"

void main() {
    uint i = rx_thread();
    if (i >= queue.work) return;
    uint slot = queue.faces[i / 16u];
    texels[16u * slot + i % 16u] = fresh[i];
    // No face is new any more.
    if (i % 16u == 0u) light[slot].w = 1.0;
}
