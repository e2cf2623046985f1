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

void main() {
    uint i = rx_thread();
    if (i >= queue.count) return;
    uint slot = faces[i];
    vec3 sum = vec3(0.0);
    for (uint k = 0u; k < queue.per_face; ++k) sum += fresh[i * queue.per_face + k].rgb;
    float added = float(queue.per_face);

    vec4 old = light[slot];
    // Light from before a change counts as far as the change was small; that of older generations, hardly.
    if (state.changed != 0u) old.w = min(old.w, state.cap);
    if (generation[slot] != state.generation) old.w = min(old.w, 0.5);
    generation[slot] = state.generation;
    float n = min(old.w, max(float(push.history) - added, 0.0)) + added;
    light[slot] = vec4(old.rgb + (sum - added * old.rgb) / n, n);
}
