// Layout `chunk_table`: flat 32^3 chunks as in the layout `chunks`, found by hash in place of a search, with masks in front.
//
// A chunk is sixteen words of masks, one of 64 bits for each of its 16^3 nodes (node x + 2y + 4z), which tell the 4^3 blocks with
// solids; then its voxels, two a word, x + 32y + 1024z. Header and table are those of hashed_chunks.glsl.
#ifndef RAXEL_CHUNK_TABLE_GLSL
#define RAXEL_CHUNK_TABLE_GLSL

#include "hashed_chunks.glsl"
#include "mask.glsl"

const uint RX_CHUNK_MASK_WORDS = 16u;

uint rx_look(ivec3 cell, out uint log2_free) {
    uvec3 c = uvec3(cell) - uvec3(world.origin);
    uint chunk = rx_find_chunk(c);
    if (chunk == RX_NO_ENTRY) {
        log2_free = rx_table_free(c, RX_CHUNK_LEVEL);
        return 0u;
    }
    uvec3 node = (c >> 4) & 1u;
    uint at = chunk + 2u * (node.x | (node.y << 1) | (node.z << 2));
    uvec2 mask = uvec2(world.words[at], world.words[at + 1u]);
    uint block = rx_mask_bit(c >> 2);
    if (!rx_mask_has(mask, block)) {
        log2_free = 2u + rx_mask_free(mask, block);
        return 0u;
    }
    log2_free = 0u;
    uvec3 v = c & 31u;
    uint index = v.x | (v.y << 5) | (v.z << 10);
    return (world.words[chunk + RX_CHUNK_MASK_WORDS + (index >> 1)] >> ((index & 1u) * 16u)) & 0xffffu;
}

#include "trace.glsl"

#endif
