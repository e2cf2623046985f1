// A stream of random numbers for one path of light.
#ifndef RAXEL_LIGHT_SAMPLER_GLSL
#define RAXEL_LIGHT_SAMPLER_GLSL

#include "sobol.glsl"

// The first pairs are those of Sobol sequences over `index`, later ones are hashed: late draws on a path gain little by order.
struct RxSampler {
    uint index;  // of the path among those of this pixel or face
    uint seed;   // of the pixel or face
    uint pair;   // the next one
};

const uint RX_SAMPLER_PAIRS = 6u;

// The random numbers of the sample `index`. Another seed gives other numbers.
RxSampler rx_sampler(uint index, uint seed) {
    return RxSampler(index, seed, 0u);
}

// Two numbers in [0, 1).
vec2 rx_next2(inout RxSampler s) {
    uint pair = s.pair++;
    if (pair < RX_SAMPLER_PAIRS) return rx_sobol(s.index, pair, s.seed);
    uint state = rx_hash(s.seed ^ rx_hash(s.index ^ rx_hash(pair)));
    float x = rx_random(state);
    return vec2(x, rx_random(state));
}

// One number in [0, 1).
float rx_next(inout RxSampler s) {
    return rx_next2(s).x;
}

#endif
