// Layout `chunk_table`: flat 32^3 chunks as in the layout `chunks`, found by hash in place of a search, with masks in front.
//
// A chunk is sixteen words of masks, one of 64 bits for each of its 16^3 nodes (node x + 2y + 4z), which tell the 4^3 blocks with
// solids; then its voxels, two a word, x + 32y + 1024z. Where a chunk begins is the value of its entry in the table of table.glsl.
#ifndef RAXEL_CHUNK_TABLE_GLSL
#define RAXEL_CHUNK_TABLE_GLSL

layout(std430) readonly buffer RxWorld {
    ivec3 origin;         // smallest corner of a cube around the world
    uint log2_size;       // the cube has 2^log2_size voxels a side
    ivec3 bounds_min;     // smallest and largest coordinates of solid voxels
    uint material_count;
    ivec3 bounds_last;
    uint materials_at;    // word of the first material
    uint table_at;        // word of the hash table
    uint log2_slots;      // the table has 2^log2_slots slots
    uint chunks_at;       // word of the first chunk
    uint chunk_count;     // chunks of voxels; equal chunks share them
    uint words[];
} world;

#include "material.glsl"
#include "mask.glsl"
#include "table.glsl"

const uint RX_CHUNK_LEVEL = 5u;
const uint RX_CHUNK_MASK_WORDS = 16u;

// The chunk that this thread found last: a ray stays in a chunk for many cells.
uvec3 rx_last_cell = uvec3(0xffffffffu);
uint rx_last_chunk = RX_NO_ENTRY;

uint rx_find_chunk(uvec3 c) {
    uvec3 cell = c >> RX_CHUNK_LEVEL;
    if (cell != rx_last_cell) {
        rx_last_cell = cell;
        rx_last_chunk = rx_table_find(c, RX_CHUNK_LEVEL);
    }
    return rx_last_chunk;
}

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
