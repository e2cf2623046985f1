// Hashes and random numbers that are the same on every device: integers only.
#ifndef RAXEL_RANDOM_GLSL
#define RAXEL_RANDOM_GLSL

// PCG's output permutation over one step of its generator (Jarzynski and Olano, "Hash functions for GPU rendering", 2020).
uint rx_hash(uint v) {
    uint state = v * 747796405u + 2891336453u;
    uint word = ((state >> ((state >> 28) + 4u)) ^ state) * 277803737u;
    return (word >> 22) ^ word;
}

// The same for three integers.
uint rx_hash(ivec3 cell) {
    return rx_hash(uint(cell.x) + rx_hash(uint(cell.y) + rx_hash(uint(cell.z))));
}

// The next number of a sequence; `state` is any seed.
uint rx_random_uint(inout uint state) {
    state += 1u;
    return rx_hash(state);
}

// In [0, 1), a multiple of 2^-24.
float rx_random(inout uint state) {
    return float(rx_random_uint(state) >> 8) * 5.9604644775390625e-8;
}

// Uniform on the unit sphere.
vec3 rx_random_direction(inout uint state) {
    float z = 1.0 - 2.0 * rx_random(state);
    float angle = 6.28318530718 * rx_random(state);
    return vec3(sqrt(max(0.0, 1.0 - z * z)) * vec2(cos(angle), sin(angle)), z);
}

#endif
