// The new samples of each listed face go into its mean, and their squares into another one.
#version 460
#include <raxel/thread.glsl>

layout(local_size_x = 64) in;
#include "queue.glsl"
layout(std430) readonly buffer Faces { uint faces[]; };
layout(std430) readonly buffer Fresh { vec4 fresh[]; };
#include "../change.glsl"
layout(std430) buffer Generation { uint generation[]; };
layout(std430) buffer Light { vec4 light[]; };
layout(std430) buffer Squares { float squares[]; };
layout(push_constant) uniform Push { int history; } push;
#include "../renew.glsl"

void main() {
    uint i = rx_thread();
    if (i >= queue.count) return;
    uint slot = faces[i];
    vec3 sum = vec3(0.0);
    float square = 0.0;
    for (uint k = 0u; k < queue.per_face; ++k) {
        vec3 one = fresh[i * queue.per_face + k].rgb;
        float luminance = min(dot(one, vec3(0.2126, 0.7152, 0.0722)), 1e15);
        sum += one;
        square += luminance * luminance;
    }
    float added = float(queue.per_face);
    vec4 now = renewed(slot, light[slot], sum, added, float(push.history));
    light[slot] = now;
    squares[slot] = (square + (now.w - added) * squares[slot]) / now.w;
}
