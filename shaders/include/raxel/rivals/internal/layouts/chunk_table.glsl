// Layout `chunk_table`: flat 32^3 chunks as in the layout `chunks`, found by hash in place of a search, with masks in front.
//
// A chunk is sixteen words of masks, one of 64 bits for each of its 16^3 nodes (node x + 2y + 4z), which mark the 4^3 blocks with solids;
// then its voxels, two a word, x + 32y + 1024z. Header and table are those of hashed_chunks.glsl.
#include <raxel/internal/hashed_chunks.glsl>
#include <raxel/internal/mask.glsl>

const uint RX_CHUNK_MASK_WORDS = 16u;

// Word of the mask of the 16^3 node that holds `c`.
uint rx_node_mask(uint chunk, uvec3 c) {
    uvec3 node = (c >> 4) & 1u;
    return chunk + 2u * (node.x | (node.y << 1) | (node.z << 2));
}

// Number of a voxel in its chunk.
uint rx_chunk_index(uvec3 c) {
    uvec3 v = c & 31u;
    return v.x | (v.y << 5) | (v.z << 10);
}

uint rx_look(ivec3 cell, out uint log2_free) {
    uvec3 c = uvec3(cell) - uvec3(world.origin);
    uint chunk = rx_find_chunk(c);
    if (chunk == RX_NO_ENTRY) {
        log2_free = rx_table_free(c, RX_CHUNK_LEVEL);
        return 0u;
    }
    uint at = rx_node_mask(chunk, c);
    uvec2 mask = uvec2(world.words[at], world.words[at + 1u]);
    uint block = rx_mask_bit(c >> 2);
    if (!rx_mask_has(mask, block)) {
        log2_free = 2u + rx_mask_free(mask, block);
        return 0u;
    }
    log2_free = 0u;
    uint index = rx_chunk_index(c);
    return (world.words[chunk + RX_CHUNK_MASK_WORDS + (index >> 1)] >> ((index & 1u) * 16u)) & 0xffffu;
}

#include <raxel/internal/trace.glsl>

#ifdef RX_WRITE
#include "../store.glsl"

// A voxel of a chunk that the copy has. When the last voxel of a 4^3 block is removed, the block's bit stays set: rays look at its
// voxels one by one until the copy is filled again.
bool rx_set(ivec3 cell, uint material) {
    if (!rx_in_world(cell)) return false;
    uvec3 c = uvec3(cell) - uvec3(world.origin);
    uint chunk = rx_find_chunk(c);
    if (chunk == RX_NO_ENTRY) return false;
    if (material != 0u) {
        uint block = rx_mask_bit(c >> 2);
        atomicOr(world.words[rx_node_mask(chunk, c) + (block >> 5)], 1u << (block & 31u));
    }
    uint index = rx_chunk_index(c);
    return rx_store_voxel(chunk + RX_CHUNK_MASK_WORDS + (index >> 1), index & 1u, material);
}
#endif
