// Layout `svo`: a sparse octree in a buffer, one word a node inside 64^3 chunks.
//
// A node is
//     bits 0 to 7   occupied children, child x + 2y + 4z
//     bit 8         all of them are filled with the material in bits 16 to 31; none is stored
//     bits 9 to 31  else: where they are stored, packed in the order of the mask. Counted from the first word of the chunk, in words;
//                   or, if the children are voxels, where their materials are, in halfwords
// The nodes from the root down to the chunks, both included, are two words: such a node without a pointer, and the word of the first
// child (two words each); or of a chunk, its node and its first word. Equal chunks are stored once.
//
// After Laine and Karras, "Efficient sparse voxel octrees" (2010): one mask and one pointer for all children of a node. As pointers
// are counted from the chunk, 23 bits reach everything in it, and none is a far one.
#ifdef RX_WRITE
#error "the layout `svo` has no rx_set: nodes are packed, without room for one more; use chunks, chunk_table, octree or texture3d"
#endif

layout(std430) readonly buffer RxWorld {
#include <raxel/internal/header.glsl>
    uint root;            // word of the root node
    uint upper_count;     // nodes from the root down to the chunks
    uint chunks_at;       // word of the first chunk
    uint chunk_count;     // equal chunks are stored once
    uint words[];
} world;

#include <raxel/internal/material.glsl>
#include <raxel/internal/octant.glsl>

const uint RX_CHUNK_LEVEL = 6u;
const uint RX_SOLID = 0x100u;

// The path to the cell of this thread's last look, down to cubes of 64^3 and 8^3. Most looks begin below one of these cubes.
uvec3 rx_last_chunk = uvec3(0xffffffffu);
uint rx_chunk_node = 0u;
uint rx_chunk_at = 0u;
uvec3 rx_last_cube = uvec3(0xffffffffu);
uint rx_cube_node = 0u;

// Makes the chunk of a place the last one. False if there is none, and then it lies in an empty cube of 2^log2_free voxels.
bool rx_find_chunk(uvec3 c, out uint log2_free) {
    uint at = world.root;
    for (uint height = world.log2_size; height > RX_CHUNK_LEVEL; --height) {
        uint mask = world.words[at];
        uint child = rx_octant(c, height);
        log2_free = height - 1u;
        if (((mask >> child) & 1u) == 0u) return false;
        at = world.words[at + 1u] + 2u * rx_octant_rank(mask, child);
    }
    rx_last_chunk = c >> RX_CHUNK_LEVEL;
    rx_last_cube = uvec3(0xffffffffu);  // its words are counted from the chunk's
    rx_chunk_node = world.words[at];
    rx_chunk_at = world.words[at + 1u];
    return true;
}

uint rx_look(ivec3 cell, out uint log2_free) {
    uvec3 c = uvec3(cell) - uvec3(world.origin);
    uint height = 3u;
    uint node = rx_cube_node;
    if ((c >> 3) != rx_last_cube) {
        if ((c >> RX_CHUNK_LEVEL) != rx_last_chunk && !rx_find_chunk(c, log2_free)) return 0u;
        height = RX_CHUNK_LEVEL;
        node = rx_chunk_node;
    }
    for (; ; --height) {
        uint child = rx_octant(c, height);
        log2_free = height - 1u;
        if (((node >> child) & 1u) == 0u) return 0u;
        if ((node & RX_SOLID) != 0u) return node >> 16;
        uint at = (node >> 9) + rx_octant_rank(node, child);
        if (height == 1u) {
            at += 2u * rx_chunk_at;
            return (world.words[at >> 1] >> ((at & 1u) * 16u)) & 0xffffu;
        }
        node = world.words[rx_chunk_at + at];
        if (height == 4u) {
            rx_last_cube = c >> 3;
            rx_cube_node = node;
        }
    }
    return 0u;
}

#include <raxel/internal/trace.glsl>
