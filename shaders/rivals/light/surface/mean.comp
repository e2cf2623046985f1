// The new samples of each item go into its mean. A sum in floats over all samples: it never stops short and never clips.
#version 460
#include <raxel/thread.glsl>

layout(local_size_x = 64) in;
#include "work.glsl"
layout(std430) readonly buffer Fresh { vec4 fresh[]; };
#define CACHE_ACCESS
#include "light/face_cache/cache.glsl"
layout(std430) buffer Texels { vec4 texels[]; };
layout(push_constant) uniform Push { int history; } push;

vec4 joined(vec4 old, vec4 sum) {
    float n = min(old.w, max(float(push.history) - sum.w, 0.0)) + sum.w;
    return n > 0.0 ? vec4(old.rgb + (sum.rgb - sum.w * old.rgb) / n, n) : old;
}

void main() {
    uint i = rx_thread();
    if (i >= work.count) return;
    vec4 sum = vec4(0.0);
    for (uint k = 0u; k < work.per_item; ++k) sum += fresh[i * work.per_item + k];
    uint item = items[i];
    if (item == NO_ITEM) return;
    if ((item & TEXEL_ITEM) == 0u) light[item] = joined(light[item], sum);
    else texels[item & ~TEXEL_ITEM] = joined(texels[item & ~TEXEL_ITEM], sum);
}
