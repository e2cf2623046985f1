// Masks of 4 x 4 x 4 cells: two words, bit x + 4z + 16y.
#ifndef RAXEL_MASK_GLSL
#define RAXEL_MASK_GLSL

// Bit of a cell; only the two lowest bits of each coordinate count.
uint rx_mask_bit(uvec3 cell) {
    uvec3 c = cell & 3u;
    return c.x | (c.z << 2) | (c.y << 4);
}

bool rx_mask_has(uvec2 mask, uint bit) {
    return (((bit >= 32u ? mask.y : mask.x) >> (bit & 31u)) & 1u) != 0u;
}

// Set bits before `bit`.
uint rx_mask_rank(uvec2 mask, uint bit) {
    uint below = (1u << (bit & 31u)) - 1u;
    return bit >= 32u ? uint(bitCount(mask.x) + bitCount(mask.y & below)) : uint(bitCount(mask.x & below));
}

// Around a bit that is not set: binary logarithm of the largest aligned cube of cells without a set bit, 0 to 2.
uint rx_mask_free(uvec2 mask, uint bit) {
    if ((mask.x | mask.y) == 0u) return 2u;
    uint corner = bit & 42u;
    return (((corner >= 32u ? mask.y : mask.x) >> (corner & 31u)) & 0x00330033u) == 0u ? 1u : 0u;
}

#endif
