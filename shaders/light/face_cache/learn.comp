// Adds the lamps that lit faces in this frame to the known lamps (known_lamps.glsl). A lamp that has not lit any for 16 frames counts
// half; regions forget it after 48.
#version 460
#include "../frame.glsl"

layout(local_size_x = 64) in;
#define KNOWN_ACCESS
#include "known.glsl"

shared uint members[64];   // of each thread

// A word of a list after this frame.
uint learned(uint old, uint at, uint bits) {
    uint now = found[at];
    if ((frame.index & 15u) == 0u && old != 0u) old = old >> bits > 1u ? old - (1u << bits) : 0u;
    if (now != 0u) found[at] = 0u;
    return max(old, now);
}

void main() {
    uint i = gl_GlobalInvocationID.x;
    bool of_region = 4u * i >= REGION_SETS;
    uvec4 old = known[i], words;
    uint own = 0u;
    for (uint k = 0u; k < 4u; ++k) {
        words[k] = learned(old[k], 4u * i + k, of_region ? REGION_BITS : KNOWN_BITS);
        own += words[k] != 0u ? 1u : 0u;
    }
    if (of_region) {
        // A group has a region's list. Members stand in a row, so that each is drawn as often as all others.
        members[gl_LocalInvocationIndex] = own;
        barrier();
        uint before = 0u, all = 0u;
        for (uint thread = 0u; thread < gl_WorkGroupSize.x; ++thread) {
            if (thread == gl_LocalInvocationIndex) before = all;
            all += members[thread];
        }
        uint row = REGION_ROWS + gl_WorkGroupID.x * REGION_EACH - REGION_SETS;
        for (uint k = 0u; k < 4u; ++k) {
            if (words[k] == 0u) continue;
            ++before;
            if (before < REGION_EACH) known[(row + before) / 4u][(row + before) % 4u] = words[k];
            else words[k] = 0u;
        }
        if (gl_LocalInvocationIndex == 0u) known[row / 4u][0] = min(all, REGION_EACH - 1u);
    }
    if (words != old) known[i] = words;
}
