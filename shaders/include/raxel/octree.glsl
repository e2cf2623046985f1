// Layout `octree`: a complete octree for each 32^3 chunk, in which every node has a place, empty ones too, and a hash table of chunks.
//
// A chunk is 1 + 8 + 64 + 512 + 4096 + 32768 words: its nodes by depth, from the chunk itself (depth 0) to voxels (depth 5), those of
// a depth in Morton order, so that child n of the node at index i of depth d is at index 8i + n of depth d + 1, and depth d begins at
// 8^0 + ... + 8^(d-1). No pointers are stored: a voxel is changed by writing one node a depth. A node is
//     bits 0 to 7    children with solids, child x + 2y + 4z
//     bit 8          all voxels in it are solid and of its material
//     bits 16 to 31  material of its first solid voxel
// and 0 if it is empty. Where a chunk begins is the value of its entry in the table of table.glsl.
//
// This is the bitmask octree of a Vulkan voxel engine's public development log (entry of 2024-05-01); bit 8 is added here.
#ifndef RAXEL_OCTREE_GLSL
#define RAXEL_OCTREE_GLSL

layout(std430) readonly buffer RxWorld {
    ivec3 origin;         // smallest corner of a cube around the world
    uint log2_size;       // the cube has 2^log2_size voxels a side
    ivec3 bounds_min;     // smallest and largest coordinates of solid voxels
    uint material_count;
    ivec3 bounds_last;
    uint materials_at;    // word of the first material
    uint table_at;        // word of the hash table of chunks
    uint log2_slots;      // the table has 2^log2_slots slots
    uint chunks_at;       // word of the first chunk's nodes
    uint chunk_count;     // chunks of nodes; equal chunks share them
    uint words[];
} world;

#include "material.glsl"
#include "table.glsl"

const uint RX_CHUNK_LEVEL = 5u;
const uint RX_FILLED = 0x100u;

// The chunk that this thread found last.
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
    uint first = 0u, index = 0u;  // of this depth, and in it
    for (uint height = RX_CHUNK_LEVEL; ; --height) {
        uint node = world.words[chunk + first + index];
        log2_free = height;
        if ((node & RX_FILLED) != 0u) return node >> 16;
        if (height == 0u) return 0u;
        uvec3 child = (c >> (height - 1u)) & 1u;
        uint number = child.x | (child.y << 1) | (child.z << 2);
        log2_free = height - 1u;
        if (((node >> number) & 1u) == 0u) return 0u;
        first = 8u * first + 1u;
        index = 8u * index + number;
    }
    return 0u;
}

// Whether the cube of 2^level voxels around a cell may have a solid voxel, for march/pyramid.glsl: the way down ends where the cube is.
#define RX_HAS_OCCUPIED
bool rx_occupied(ivec3 cell, uint level) {
    uvec3 c = uvec3(cell) - uvec3(world.origin);
    uint chunk = rx_find_chunk(c);
    if (chunk == RX_NO_ENTRY) return rx_table_free(c, RX_CHUNK_LEVEL) < level;
    uint first = 0u, index = 0u;
    for (uint height = RX_CHUNK_LEVEL; height > level; --height) {
        uint node = world.words[chunk + first + index];
        if ((node & RX_FILLED) != 0u) return true;
        uvec3 child = (c >> (height - 1u)) & 1u;
        uint number = child.x | (child.y << 1) | (child.z << 2);
        if (((node >> number) & 1u) == 0u) return false;
        first = 8u * first + 1u;
        index = 8u * index + number;
    }
    return true;
}

#include "trace.glsl"

#endif
