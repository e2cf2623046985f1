// The new samples of each cell go into its mean.
#version 460
#include <raxel/thread.glsl>

layout(local_size_x = 64) in;
#include "light/face_cache/queue.glsl"
#include "light/change.glsl"
#include "sums.glsl"
#define CACHE_ACCESS
#include "light/face_cache/cache.glsl"
layout(push_constant) uniform Push { int history; } push;
#include "light/renew.glsl"

void main() {
    uint i = rx_thread();
    if (i >= queue.count) return;
    uint slot = queue.faces[i];
    vec4 sum = sums_take(slot);
    light[slot] = renewed(slot, light[slot], sum.rgb, sum.w, float(push.history));
}
