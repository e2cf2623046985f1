// Sums of light in 64-bit whole numbers of 2^-20: exact, in any order of threads.
struct CellSum {
    uint light[6];  // red, green, blue, each by its low and its high word
    uint samples;
    uint unused;
};
layout(std430) buffer Fresh { CellSum fresh[]; };

const float SUMS_MOST = 1e12;  // as much of one sample is counted

void sums_add(uint slot, vec3 light) {
    for (uint c = 0u; c < 3u; ++c) {
        float value = clamp(light[c], 0.0, SUMS_MOST);
        float high = floor(value * 2.44140625e-4);  // of 2^12, which is 2^32 in the low word
        uint low = uint((value - high * 4096.0) * 1048576.0);
        uint before = atomicAdd(fresh[slot].light[2u * c], low);
        uint more = uint(high) + (before > 0xffffffffu - low ? 1u : 0u);
        if (more != 0u) atomicAdd(fresh[slot].light[2u * c + 1u], more);
    }
    atomicAdd(fresh[slot].samples, 1u);
}

// The sum of a slot and the number of its samples; empties them.
vec4 sums_take(uint slot) {
    vec4 sum = vec4(0.0, 0.0, 0.0, float(fresh[slot].samples));
    fresh[slot].samples = 0u;
    for (uint c = 0u; c < 3u; ++c) {
        sum[c] = float(fresh[slot].light[2u * c + 1u]) * 4096.0 + float(fresh[slot].light[2u * c]) * 9.5367431640625e-7;
        fresh[slot].light[2u * c] = 0u;
        fresh[slot].light[2u * c + 1u] = 0u;
    }
    return sum;
}
