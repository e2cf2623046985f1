// Lamps that have lit faces in this frame join those that are known (known_lamps.glsl). What has not lit any for 16 frames counts half. Lists of near lamps
// (near_lamps.glsl) fill their empty places at once, and are replaced by those of a whole turn at its end.
#version 460
#include <raxel/random.glsl>
#include "../frame.glsl"
#include "near_lamps.glsl"

layout(local_size_x = 64) in;
layout(std430) buffer Known { uvec4 known[]; };
layout(std430) buffer Found { uint found[]; };

uint learned_known(uint old, uint first) {
    uint now = found[first];
    if ((frame.index & 15u) == 0u && old != 0u) old = old >> 27 > 1u ? old - (1u << 27) : 0u;
    if (now != 0u) found[first] = 0u;
    return max(old, now);
}

uint learned_near(uint old, uint first) {
    uint turn = frame.index / NEAR_TURNS;
    bool ends = frame.index % NEAR_TURNS == NEAR_TURNS - 1u;
    if (!ends && old != 0u) return old;
    uint now = found[first], place = near_plain(now & NEAR_PLACE, turn);
    if (ends && now != 0u) found[first] = 0u;
    // Of another turn, if frames have been left out.
    return now == 0u || near_slot(place) != (first & NEAR_EACH - 1u) ? 0u : now & ~NEAR_PLACE | place;
}

void main() {
    uint i = gl_GlobalInvocationID.x;
    uvec4 old = known[i], words;
    bool is_known = 4u * i < KNOWN_CELLS * KNOWN_EACH;
    for (uint k = 0u; k < 4u; ++k) words[k] = is_known ? learned_known(old[k], 4u * i + k) : learned_near(old[k], 4u * i + k);
    if (words != old) known[i] = words;
}
