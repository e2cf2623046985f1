// First stage, second half: lists the faces for new light in this frame. They are all new faces, and as many others, in turn, as there are paths for.
#version 460
#include <raxel/thread.glsl>
#include "light/scene.glsl"

layout(local_size_x = 64) in;
#include "light/face_cache/queue.glsl"
#include "light/unwrapped.glsl"
#define WORK_ACCESS
#include "work.glsl"
#include "light/face_cache/cache.glsl"
layout(push_constant) uniform Push { ivec2 size; float paths; } push;

void main() {
    uint i = rx_thread();
    if (i >= queue.count) return;
    uint slot = queue.faces[i];
    RxFaceKey key;
    if (!rx_face_in_slot(slot, key)) return;
    // A share of the paths is reserved for new faces, so known faces never fill the list.
    float budget = max(0.9 * push.paths * float(push.size.x * push.size.y), 1.0);
    uint every = uint(max(ceil(float(work.wanted) / budget), 1.0));
    bool fresh = light[slot].w == 0.0;
    if (!fresh && (rx_hash(key.home ^ key.rest) + frame.index) % every != 0u) return;
    uint block = block_of(slot), count = block == NO_BLOCK ? 1u : 16u, first = atomicAdd(work.count, count);
    for (uint k = 0u; k < count && first + k < items.length(); ++k) {
        bool fits = first + count <= items.length();
        items[first + k] = !fits ? NO_ITEM : block == NO_BLOCK ? slot : TEXEL_ITEM | 16u * block + k;
    }
}
