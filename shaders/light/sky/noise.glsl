// Noise of random values at the points of a lattice, smoothly blended; 0 to 1.
#ifndef SKY_NOISE_GLSL
#define SKY_NOISE_GLSL

#include <raxel/random.glsl>

float noise_value(uint hash) {
    return float(hash >> 8) * 5.9604644775390625e-8;
}

// Four look-ups of the hash.
float noise2(vec2 at) {
    vec2 cell = floor(at), part = at - cell;
    part = part * part * (3.0 - 2.0 * part);
    ivec2 c = ivec2(cell);
    uint low = rx_hash(uint(c.y)), high = rx_hash(uint(c.y + 1));
    return mix(mix(noise_value(rx_hash(uint(c.x) + low)), noise_value(rx_hash(uint(c.x + 1) + low)), part.x),
               mix(noise_value(rx_hash(uint(c.x) + high)), noise_value(rx_hash(uint(c.x + 1) + high)), part.x), part.y);
}

// Eight look-ups of the hash.
float noise3(vec3 at) {
    float cell = floor(at.y), part = at.y - cell;
    part = part * part * (3.0 - 2.0 * part);
    float shift = 37.0 * cell;
    return mix(noise2(at.xz + shift), noise2(at.xz + shift + 37.0), part);
}

#endif
