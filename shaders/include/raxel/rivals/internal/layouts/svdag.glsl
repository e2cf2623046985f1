// Layout `svdag`: a sparse octree with leaves of 4^3 voxels. It stores equal subtrees once, even if their materials differ.
//
// Inside 64^3 chunks, a leaf is the 64-bit mask of its voxels (two words). A node is one word, with the mask of its children in bits
// 0 to 7 (child x + 2y + 4z) and its number of solid voxels above; then the word of each of them in turn. From the root down to the
// chunks a node has the mask only, and the last nodes lead to instances: the word of a chunk's topmost node, and a link to its
// materials. A cube of one chunk has an instance for a root.
//
// Materials are in the order in which a walk over the chunk meets its voxels. A voxel's number in that order is the sum of the voxels
// of all siblings passed on the way down. So shared geometry can have any materials. An instance's link with the top bit set is the
// one material of the chunk; without, it is where the chunk's blocks are, one word for 64 voxels, from attributes_at. A block's word
// with the top bit set is again a material. Otherwise, its low 28 bits are the place of the packed block, from attributes_at, and bits 28 to 30
// are k. The block has a palette of 2^(2^k) materials, two a word, then 2^k bits for each voxel. With k = 4 there is no palette, and the 16
// bits are the material. Equal blocks are stored once.
//
// Kämpe, Sintorn and Assarsson, "High resolution sparse voxel DAGs" (2013); materials as in Dado, Kol, Bauszat, Thiery and Eisemann,
// "Geometry and attribute compression for voxel scenes" (2016), and voxel counts in nodes as in Dolonius, Sintorn, Kämpe and
// Assarsson, "Compressing color data for voxelized surface geometry" (2017).
#ifdef RX_WRITE
#error "the layout `svdag` has no rx_set: equal subtrees are stored once, without room for one more; use chunks, chunk_table, octree or texture3d"
#endif

layout(std430) readonly buffer RxWorld {
#include <raxel/internal/header.glsl>
    uint root;            // word of the root
    uint node_count;      // different nodes and leaves inside chunks
    uint leaf_count;      // different leaves
    uint attributes_at;   // word where the materials of voxels begin
    uint words[];
} world;

#include <raxel/internal/material.glsl>
#include <raxel/internal/mask.glsl>
#include <raxel/internal/octant.glsl>

const uint RX_CHUNK_LEVEL = 6u;
const uint RX_TOP_BIT = 0x80000000u;

// The chunk that this thread looked at last, and the leaf.
uvec3 rx_last_chunk = uvec3(0xffffffffu);
uint rx_instance = 0u;
uvec3 rx_last_leaf = uvec3(0xffffffffu);
uvec2 rx_leaf_mask = uvec2(0u);

// Makes the chunk of a place the last one. False if there is none, and then it lies in an empty cube of 2^log2_free voxels.
bool rx_find_instance(uvec3 c, out uint log2_free) {
    uint at = world.root;
    for (uint height = world.log2_size; height > RX_CHUNK_LEVEL; --height) {
        uint mask = world.words[at];
        uint child = rx_octant(c, height);
        log2_free = height - 1u;
        if (((mask >> child) & 1u) == 0u) return false;
        at = world.words[at + 1u + rx_octant_rank(mask, child)];
    }
    rx_last_chunk = c >> RX_CHUNK_LEVEL;
    rx_last_leaf = uvec3(0xffffffffu);  // materials are looked up in the last chunk
    rx_instance = at;
    return true;
}

// Solid voxels of a chunk before a solid one, in the order of the graph.
uint rx_voxel_number(uvec3 c) {
    uint at = world.words[rx_instance];
    uint before = 0u;
    for (uint height = RX_CHUNK_LEVEL; height > 2u; --height) {
        uint rank = rx_octant_rank(world.words[at] & 0xffu, rx_octant(c, height));
        for (uint i = 0u; i < rank; ++i) {
            uint sibling = world.words[at + 1u + i];
            before += height > 3u ? world.words[sibling] >> 8
                                  : uint(bitCount(world.words[sibling]) + bitCount(world.words[sibling + 1u]));
        }
        at = world.words[at + 1u + rank];
    }
    return before + rx_mask_rank(uvec2(world.words[at], world.words[at + 1u]), rx_mask_bit(c));
}

// Material of a solid voxel in the last chunk.
uint rx_voxel_material(uvec3 c) {
    uint link = world.words[rx_instance + 1u];
    if ((link & RX_TOP_BIT) != 0u) return link & 0xffffu;
    uint number = rx_voxel_number(c);
    uint block = world.words[world.attributes_at + link + (number >> 6)];
    if ((block & RX_TOP_BIT) != 0u) return block & 0xffffu;
    uint kind = block >> 28;
    uint at = world.attributes_at + (block & 0x0fffffffu);
    uint bits = 1u << kind;
    uint bit = (number & 63u) << kind;
    uint values = at + (kind == 4u ? 0u : (1u << bits) >> 1);
    uint value = (world.words[values + (bit >> 5)] >> (bit & 31u)) & ((1u << bits) - 1u);
    return kind == 4u ? value : (world.words[at + (value >> 1)] >> ((value & 1u) * 16u)) & 0xffffu;
}

uint rx_look(ivec3 cell, out uint log2_free) {
    uvec3 c = uvec3(cell) - uvec3(world.origin);
    if ((c >> 2) != rx_last_leaf) {
        if ((c >> RX_CHUNK_LEVEL) != rx_last_chunk && !rx_find_instance(c, log2_free)) return 0u;
        uint at = world.words[rx_instance];
        for (uint height = RX_CHUNK_LEVEL; height > 2u; --height) {
            uint node = world.words[at];
            uint child = rx_octant(c, height);
            log2_free = height - 1u;
            if (((node >> child) & 1u) == 0u) return 0u;
            at = world.words[at + 1u + rx_octant_rank(node & 0xffu, child)];
        }
        rx_last_leaf = c >> 2;
        rx_leaf_mask = uvec2(world.words[at], world.words[at + 1u]);
    }
    uint bit = rx_mask_bit(c);
    if (!rx_mask_has(rx_leaf_mask, bit)) {
        log2_free = rx_mask_free(rx_leaf_mask, bit);
        return 0u;
    }
    log2_free = 0u;
    return rx_voxel_material(c);
}

#include <raxel/internal/trace.glsl>
