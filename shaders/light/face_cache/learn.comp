// Lamps that have lit faces in this frame join those that are known (known_lamps.glsl). What has not lit any for 16 frames counts half.
#version 460
#include "../frame.glsl"

layout(local_size_x = 64) in;
layout(std430) buffer Known { uint known[]; };
layout(std430) buffer Found { uint found[]; };

void main() {
    uint i = gl_GlobalInvocationID.x, now = found[i], old = known[i];
    if (now == 0u && (old == 0u || (frame.index & 15u) != 0u)) return;
    if ((frame.index & 15u) == 0u && old != 0u) old = old >> 27 > 1u ? old - (1u << 27) : 0u;
    known[i] = max(old, now);
    found[i] = 0u;
}
