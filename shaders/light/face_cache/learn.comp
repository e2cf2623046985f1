// Lamps that have lit faces in this frame join those that are known (known_lamps.glsl). What has not lit any for 16 frames counts half.
#version 460
#include "../frame.glsl"

layout(local_size_x = 64) in;
#define KNOWN_ACCESS
#include "known.glsl"

void main() {
    uint i = gl_GlobalInvocationID.x;
    bool fades = (frame.index & 15u) == 0u;
    uvec4 old = known[i], words = old;
    for (uint k = 0u; k < 4u; ++k) {
        uint now = found[4u * i + k];
        if (fades && words[k] != 0u) words[k] = words[k] >> 27 > 1u ? words[k] - (1u << 27) : 0u;
        words[k] = max(words[k], now);
        if (now != 0u) found[4u * i + k] = 0u;
    }
    if (words != old) known[i] = words;
}
