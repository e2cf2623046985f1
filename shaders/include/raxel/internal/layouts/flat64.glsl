// Layout `flat64`: a grid of records of 16^3 voxels over the box of the world, and leaves, which are masks of 4^3 voxels. No tree has to
// be gone down and none is kept: any cell is two reads away. Worlds of at most 2048 x 1024 x 2048 voxels.
//
// The record of the block at (x, y, z) is at x + (strides & 0xffff) * z + (strides >> 16) * y behind the first, and is four words, read
// at once:
//
//     mask             two words: which of its 4^3 blocks have solids (x + 4z + 16y)
//     first leaf - 1   leaves are packed in the order of the mask
//     free radii       four bits for each octant of directions (bit a of its number: down along axis a): how many blocks of 16^3
//                      further on, in all directions that such a ray goes, have no solids either
//
// Leaf l has the link `links_at` + l - `leaves_at`: RX_UNIFORM | material, or where the materials of its voxels are, packed in the
// order of its mask (packed.glsl). Blocks of 16^3 that are full of one material share their leaves.
//
// Free radii follow the anisotropic Chebyshev distances of Deakin and Knackstedt, "Efficient ray casting of volumetric images using distance
// maps for empty space skipping" (2020): only voxels ahead of a ray count, because it never turns.
#ifdef RX_WRITE
#error "the layout `flat64` has no rx_set: leaves are packed, without room for one more; use chunks, chunk_table, octree or texture3d"
#endif

layout(std430) readonly buffer RxWorld {
#include "../header.glsl"
    uint records_at;      // the first record, counted in records
    uint strides;         // records from one to the next along z (low half) and y
    uint leaves_at;       // the first leaf, counted in leaves
    uint links_at;        // word of the first leaf's link
    uvec4 quads[];
} world;

#define RX_QUADS
#include "../material.glsl"
#undef RX_QUADS
#include "../mask.glsl"

const uint RX_UNIFORM = 0x40000000u;
#include "../packed.glsl"

// Mask of a leaf.
uvec2 rx_leaf(uint leaf) {
    uvec4 pair = world.quads[leaf >> 1];
    return (leaf & 1u) != 0u ? pair.zw : pair.xy;
}

uint rx_leaf_material(uint leaf, uvec2 mask, uint voxel) {
    return rx_linked_material(rx_word(world.links_at + leaf - world.leaves_at), rx_mask_rank(mask, voxel));
}

// As trace.glsl has it.
uint rx_look(ivec3 cell, out uint log2_free) {
    uvec3 c = uvec3(cell) - uvec3(world.origin);
    uvec3 at = c >> 4, last = (uvec3(world.bounds_last) - uvec3(world.origin)) >> 4;
    log2_free = 4u;
    // The cube is larger than the box of the records.
    if (at.x > last.x || at.y > last.y || at.z > last.z) return 0u;
    uvec4 block = world.quads[world.records_at + at.x + (world.strides & 0xffffu) * at.z + (world.strides >> 16) * at.y];
    uint bit = rx_mask_bit(c >> 2);
    if (!rx_mask_has(block.xy, bit)) {
        log2_free = 2u + rx_mask_free(block.xy, bit);
        return 0u;
    }
    uint leaf = block.z + 1u + rx_mask_rank(block.xy, bit);
    uvec2 mask = rx_leaf(leaf);
    uint voxel = rx_mask_bit(c);
    if (rx_mask_has(mask, voxel)) return rx_leaf_material(leaf, mask, voxel);
    log2_free = rx_mask_free(mask, voxel);
    return 0u;
}

#include "../trace.glsl"
