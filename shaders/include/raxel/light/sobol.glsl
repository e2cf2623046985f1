// Owen-scrambled Sobol points without tables: pairs of dimensions, each pair a shuffled and scrambled (0,2)-sequence of its own
// (Burley, "Practical hash-based Owen scrambling", 2020, section 4, "padding"). The first 2^k points of a pair are stratified in all elementary
// intervals. Different pairs and different seeds are independent.
#ifndef RAXEL_LIGHT_SOBOL_GLSL
#define RAXEL_LIGHT_SOBOL_GLSL

#include "../random.glsl"

// Owen scrambling of a number whose bits are reversed (Laine and Karras 2011, with the constants of Vegdahl, "Building a better
// LK hash", 2021): only lower bits change a bit.
uint rx_owen_reversed(uint x, uint seed) {
    x ^= x * 0x3d20adeau;
    x += seed;
    x *= (seed >> 16) | 1u;
    x ^= x * 0x05526c56u;
    x ^= x * 0x53a22864u;
    return x;
}

// The generator matrix of the second dimension, Pascal's triangle modulo 2, times an index; the result has its bits reversed. Bit k is
// the parity of the bits whose positions contain k as a set of bits (Lucas' theorem), which five steps sum up.
uint rx_pascal(uint index) {
    index ^= (index >> 16) & 0x0000ffffu;
    index ^= (index >> 8) & 0x00ff00ffu;
    index ^= (index >> 4) & 0x0f0f0f0fu;
    index ^= (index >> 2) & 0x33333333u;
    index ^= (index >> 1) & 0x55555555u;
    return index;
}

// The point `index` of a pair of dimensions, in 32 random bits each. `seed` is another for each pixel or face.
uvec2 rx_sobol_bits(uint index, uint pair, uint seed) {
    seed = rx_hash(seed ^ rx_hash(pair));
    index = bitfieldReverse(rx_owen_reversed(bitfieldReverse(index), seed));
    return bitfieldReverse(uvec2(rx_owen_reversed(index, rx_hash(seed ^ 0x9e3779b9u)),
                                 rx_owen_reversed(rx_pascal(index), rx_hash(seed ^ 0x7f4a7c15u))));
}

// The same in [0, 1), multiples of 2^-24.
vec2 rx_sobol(uint index, uint pair, uint seed) {
    return vec2(rx_sobol_bits(index, pair, seed) >> 8) * 5.9604644775390625e-8;
}

#endif
