// The common part of the layouts `chunk_table` and `octree`: 32^3 chunks, all of the same number of words, found by the hash table of
// table.glsl. The value of a chunk's entry is the word where it begins. engine/layouts/src/hashed_chunks writes it.
layout(std430) RX_WORLD_ACCESS buffer RxWorld {
#include "header.glsl"
    uint table_at;        // word of the hash table of chunks
    uint log2_slots;      // the table has 2^log2_slots slots
    uint chunks_at;       // word of the first chunk
    uint chunk_count;     // different chunks; equal chunks share them
    uint words[];
} world;

#include "material.glsl"
#include "table.glsl"

const uint RX_CHUNK_LEVEL = 5u;

// The chunk that this thread found last: a ray stays in a chunk for many cells.
uvec3 rx_last_cell = uvec3(0xffffffffu);
uint rx_last_chunk = RX_NO_ENTRY;

// Word of the chunk that holds `c`, in voxels from world.origin, or RX_NO_ENTRY.
uint rx_find_chunk(uvec3 c) {
    uvec3 cell = c >> RX_CHUNK_LEVEL;
    if (cell != rx_last_cell) {
        rx_last_cell = cell;
        rx_last_chunk = rx_table_find(c, RX_CHUNK_LEVEL);
    }
    return rx_last_chunk;
}
