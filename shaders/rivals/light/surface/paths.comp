// Second stage: one path from a random place of each texel, or of the whole face: skylight, lamps and all light that other faces send back, without direct
// sun. At a face that keeps light itself, the path ends and takes that light. Paths read only the data of the last frame.
#version 460
#include <raxel/world.glsl>
#include <raxel/thread.glsl>
#include "light/scene.glsl"
#include "light/face_cache/box.glsl"

layout(local_size_x = 64) in;
#include "light/change.glsl"
#include "light/unwrapped.glsl"
#include "work.glsl"
#include "light/face_cache/cache.glsl"
layout(std430) writeonly buffer Fresh { vec4 fresh[]; };
layout(push_constant) uniform Push { int ready; int candidates; } push;
#include "item.glsl"

vec4 kept(RxHit hit) {
    if (!rx_face_fits(hit.voxel, face_box())) return vec4(0.0);
    uint slot = rx_face_find(rx_face_key(hit.voxel, hit.face, 0u));
    if (slot == RX_NO_FACE || generation[slot] != state.generation || light[slot].w < float(push.ready)) return vec4(0.0);
    return light[slot];
}

#define PATH_KEPT
#define PATH_CANDIDATES push.candidates
#include "light/path.glsl"

void main() {
    uint i = rx_thread();
    if (i >= work.paths) return;
    fresh[i] = vec4(0.0);
    Item item;
    if (!item_at(i / work.per_item, item)) return;
    RxSampler numbers = rx_sampler(frame.index * work.per_item + i % work.per_item, item.seed);
    vec2 uv = item.corner + item.side * rx_next2(numbers);
    fresh[i] = vec4(path_light(item.voxel, item.face, uv, numbers), 1.0);
}
