// The new samples of each listed face go into its mean.
#version 460
#include <raxel/thread.glsl>

layout(local_size_x = 64) in;
#include "queue.glsl"
layout(std430) readonly buffer Faces { uint faces[]; };
layout(std430) readonly buffer Fresh { vec4 fresh[]; };
#include "../change.glsl"
layout(std430) buffer Generation { uint generation[]; };
layout(std430) buffer Light { vec4 light[]; };
layout(push_constant) uniform Push { int history; } push;
#include "../renew.glsl"

void main() {
    uint i = rx_thread();
    if (i >= queue.count) return;
    uint slot = faces[i];
    vec3 sum = vec3(0.0);
    for (uint k = 0u; k < queue.per_face; ++k) sum += fresh[i * queue.per_face + k].rgb;
    light[slot] = renewed(slot, light[slot], sum, float(queue.per_face), float(push.history));
}
