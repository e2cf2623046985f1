// Layout `octree`: a hash table of 32^3 chunks, each a complete octree. Every node has a place in it, empty nodes too.
//
// A chunk is 1 + 8 + 64 + 512 + 4096 + 32768 words: its nodes by depth, from the chunk (depth 0) to voxels (depth 5). In Morton order, depth d
// begins at (8^d - 1) / 7. Child n of node i of depth d is node 8i + n of depth d + 1. No pointers are stored: a voxel is changed by writing one
// node a depth. A node is
//     bits 0 to 7    children with solids, child x + 2y + 4z
//     bit 8          all voxels in it are solid and of its material
//     bits 16 to 31  material of its first solid voxel; where bit 8 is not set, that is as the encoder found it
// and 0 if it is empty. Header and table are those of hashed_chunks.glsl.
//
// This is the bitmask octree of a Vulkan voxel engine's public development log (entry of 2024-05-01); bit 8 is added here.
#include "../hashed_chunks.glsl"
#include "../octant.glsl"

const uint RX_FILLED = 0x100u;

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
        uint number = rx_octant(c, height);
        log2_free = height - 1u;
        if (((node >> number) & 1u) == 0u) return 0u;
        first = 8u * first + 1u;
        index = 8u * index + number;
    }
    return 0u;
}

// Whether the cube of 2^level voxels around a cell may have a solid voxel, for rivals/march/pyramid.glsl: the way down ends where the cube is.
bool rx_occupied(ivec3 cell, uint level) {
    uvec3 c = uvec3(cell) - uvec3(world.origin);
    uint chunk = rx_find_chunk(c);
    if (chunk == RX_NO_ENTRY) return rx_table_free(c, RX_CHUNK_LEVEL) < level;
    uint first = 0u, index = 0u;
    for (uint height = RX_CHUNK_LEVEL; height > level; --height) {
        uint node = world.words[chunk + first + index];
        if ((node & RX_FILLED) != 0u) return true;
        uint number = rx_octant(c, height);
        if (((node >> number) & 1u) == 0u) return false;
        first = 8u * first + 1u;
        index = 8u * index + number;
    }
    return true;
}

#include "../trace.glsl"

#ifdef RX_WRITE
// Sets a voxel to a material, or to air (0). False if the copy does not have the chunk of the voxel. Bits of children stay set when the
// last voxel below goes, and a node is not marked as of one material again. Rays then look deeper than they need to, until the copy is
// filled again.
bool rx_set(ivec3 cell, uint material) {
    if (!rx_in_world(cell)) return false;
    uvec3 c = uvec3(cell) - uvec3(world.origin);
    uint chunk = rx_find_chunk(c);
    if (chunk == RX_NO_ENTRY) return false;
    uint first = 0u, index = 0u;  // of this depth, and in it
    for (uint height = RX_CHUNK_LEVEL; height > 0u; --height) {
        uint at = chunk + first + index;
        uint node = world.words[at];
        uint number = rx_octant(c, height);
        if ((node & RX_FILLED) != 0u) {
            if (node >> 16 == material) return true;
            // All nodes below are stored as well.
            atomicAnd(world.words[at], ~RX_FILLED);
        }
        if (material != 0u) atomicOr(world.words[at], 1u << number);
        first = 8u * first + 1u;
        index = 8u * index + number;
    }
    atomicExchange(world.words[chunk + first + index], material == 0u ? 0u : (material << 16) | RX_FILLED | 0xffu);
    return true;
}
#endif
