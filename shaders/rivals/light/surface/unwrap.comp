// First stage: each face in sight gets texels if it is wide enough, as the original unwraps voxels. The light on the whole face
// continues as the mean of its texels. Rays that meet the face use it, and so does the face once it is far away again. The smaller a
// change was, the more the light from before it counts.
#version 460
#include <raxel/world.glsl>
#include <raxel/thread.glsl>
#include "light/scene.glsl"
#include "light/face_cache/box.glsl"

layout(local_size_x = 64) in;
#include "light/face_cache/queue.glsl"
#include "light/change.glsl"
#define UNWRAPPED_ACCESS
#include "light/unwrapped.glsl"
#define WORK_ACCESS
#include "work.glsl"
#define CACHE_ACCESS
#include "light/face_cache/cache.glsl"
layout(std430) buffer Texels { vec4 texels[]; };        // irradiance / pi without direct sun, samples
layout(std430) buffer SunTexels { vec2 sun_texels[]; }; // share of the sun times the cosine, samples
layout(push_constant) uniform Push { ivec2 pixels; float texels_from; } push;
#include "light/face_cache/across.glsl"

// A new texel begins with what the whole face knows, as if it were a few samples.
const float INHERITED = 4.0;

void main() {
    uint i = rx_thread();
    if (i >= queue.count) return;
    uint slot = queue.faces[i];
    RxFaceKey key;
    if (!rx_face_in_slot(slot, key)) return;
    ivec3 voxel;
    uint face, part;
    rx_face_of(key, face_box(), voxel, face, part);

    float most = state.changed != 0u ? state.cap : 1e9;
    if (generation[slot] != state.generation) most = min(most, 0.5);
    generation[slot] = state.generation;
    vec4 whole = light[slot];
    whole.w = min(whole.w, most);
    // A face that has been seen for the first time is not worth its texels yet.
    bool wide = whole.w > 0.0 && pixels_across(voxel, face, float(push.pixels.y)) >= push.texels_from;
    uint block = block_of(slot);
    if (wide && block == NO_BLOCK) {
        block = atomicAdd(unwrapped.given, 1u) % BLOCKS;
        uint had = unwrapped.slot_of[block];
        if (had != 0u && unwrapped.block_of[had - 1u] == block + 1u && asked[had - 1u] == frame.index + 1u) atomicAdd(work.taken, 1u);
        unwrapped.slot_of[block] = slot + 1u;
        unwrapped.block_of[slot] = block + 1u;
        for (uint k = 16u * block; k < 16u * block + 16u; ++k) {
            texels[k] = vec4(whole.rgb, min(whole.w, INHERITED));
            sun_texels[k] = vec2(0.0);
        }
    } else if (block != NO_BLOCK) {
        vec4 sum = vec4(0.0);
        for (uint k = 16u * block; k < 16u * block + 16u; ++k) {
            if (texels[k].w > most) texels[k].w = most;
            if (sun_texels[k].y > most) sun_texels[k].y = most;
            sum += vec4(texels[k].rgb, 1.0) * texels[k].w;
        }
        if (wide && sum.w > 0.0) whole = vec4(sum.rgb / sum.w, sum.w);
        // Texels that no pixel has needed for a while would be behind.
        if (!wide) unwrapped.slot_of[block] = 0u;
    }
    light[slot] = whole;
    atomicAdd(work.wanted, wide ? 16u : 1u);
}
