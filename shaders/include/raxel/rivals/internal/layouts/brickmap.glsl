// Layout `brickmap`: sectors of 64^3 voxels, in them bricks of 8^3, in them tiles of 4^3 that are one 64-bit mask each.
//
// A sector has a mask of 4^3 bricks and the word of the first brick for each of its octants (x + 2y + 4z). Bricks are packed in the
// order of the mask. A brick is seventeen words: the masks of its eight tiles (x + 2y + 4z), and a link. With the top bit set, all
// voxels of the brick are of the material in the link's low half. Otherwise it says where the materials of its solid voxels begin, in
// halfwords, in the order of tiles and of bits in a tile.
//
// A grid over the box of the world's solids leads to sectors. A cell has the word of its sector; or, with the top bit set, the
// binary logarithm of the empty cube around it. In a world that is mostly empty, the grid would be far larger than the sectors.
// Then the hash table of table.glsl has them.
//
// After van Wingerden, "Real-time ray tracing and editing of large voxel scenes" (2015), whose brickmap this is, and the XBrickMap
// of dubiousconst282/VoxelRT, where bricks are allocated by masks and tiles are 64-bit words.
#ifdef RX_WRITE
#error "the layout `brickmap` has no rx_set: bricks and materials are packed, without room for one more; use chunks, chunk_table, octree or texture3d"
#endif

layout(std430) readonly buffer RxWorld {
#include <raxel/internal/header.glsl>
    uint table_at;        // word of the grid, or of the hash table
    uint log2_slots;      // the hash table has 2^log2_slots slots; 0 if there is a grid
    uint sectors_at;      // word of the first sector
    uint sector_count;    // equal sectors are stored once
    uint words[];
} world;

#include <raxel/internal/material.glsl>
#include <raxel/internal/mask.glsl>
#include <raxel/internal/table.glsl>

const uint RX_SECTOR_LEVEL = 6u;
const uint RX_BRICK_WORDS = 17u;
const uint RX_TOP_BIT = 0x80000000u;

// The sector that this thread found last.
uvec3 rx_last_cell = uvec3(0xffffffffu);
uint rx_last_sector = RX_NO_ENTRY;

// Around a cell outside the grid: binary logarithm of the largest aligned cube that holds it and no cell of the grid.
uint rx_grid_free(uvec3 cell, uvec3 first, uvec3 last) {
    uint free = 0u;
    for (int i = 0; i < 3; ++i) {
        if (cell[i] < first[i]) free = max(free, uint(findMSB(cell[i] ^ first[i])));
        if (cell[i] > last[i]) free = max(free, uint(findMSB(cell[i] ^ last[i])));
    }
    return free;
}

// Word of a sector; or, with the top bit set, the binary logarithm of an empty cube around it.
uint rx_grid_look(uvec3 cell) {
    uvec3 first = (uvec3(world.bounds_min) - uvec3(world.origin)) >> RX_SECTOR_LEVEL;
    uvec3 last = (uvec3(world.bounds_last) - uvec3(world.origin)) >> RX_SECTOR_LEVEL;
    if (any(lessThan(cell, first)) || any(greaterThan(cell, last))) {
        return RX_TOP_BIT | (RX_SECTOR_LEVEL + rx_grid_free(cell, first, last));
    }
    uvec3 size = last - first + 1u;
    uvec3 local = cell - first;
    return world.words[world.table_at + local.x + size.x * (local.y + size.y * local.z)];
}

uint rx_find_sector(uvec3 c) {
    uvec3 cell = c >> RX_SECTOR_LEVEL;
    if (cell == rx_last_cell) return rx_last_sector;
    uint sector;
    if (world.log2_slots == 0u) {
        sector = rx_grid_look(cell);
    } else {
        sector = rx_table_find(c, RX_SECTOR_LEVEL);
        if (sector == RX_NO_ENTRY) sector = RX_TOP_BIT | rx_table_free(c, RX_SECTOR_LEVEL);
    }
    rx_last_cell = cell;
    rx_last_sector = sector;
    return sector;
}

// Material of a solid voxel: a bit of a tile of a brick.
uint rx_brick_material(uint brick, uint tile, uvec2 mask, uint bit) {
    uint link = world.words[brick + 16u];
    if ((link & RX_TOP_BIT) != 0u) return link & 0xffffu;
    uint half_word = link + rx_mask_rank(mask, bit);
    for (uint i = 0u; i < 2u * tile; ++i) half_word += uint(bitCount(world.words[brick + i]));
    return (world.words[half_word >> 1] >> ((half_word & 1u) * 16u)) & 0xffffu;
}

// The mask of the tile that rx_look found last, for march/raymask.glsl.
uvec2 rx_looked_mask = uvec2(0u);

uint rx_look(ivec3 cell, out uint log2_free) {
    uvec3 c = uvec3(cell) - uvec3(world.origin);
    uint sector = rx_find_sector(c);
    if ((sector & RX_TOP_BIT) != 0u) {
        log2_free = sector & 31u;
        return 0u;
    }
    uvec3 octant = (c >> 5) & 1u;
    uint at = sector + 3u * (octant.x | (octant.y << 1) | (octant.z << 2));
    uvec2 bricks = uvec2(world.words[at], world.words[at + 1u]);
    uint brick_bit = rx_mask_bit(c >> 3);
    if (!rx_mask_has(bricks, brick_bit)) {
        log2_free = 3u + rx_mask_free(bricks, brick_bit);
        return 0u;
    }
    uint brick = world.words[at + 2u] + RX_BRICK_WORDS * rx_mask_rank(bricks, brick_bit);
    uvec3 t = (c >> 2) & 1u;
    uint tile = t.x | (t.y << 1) | (t.z << 2);
    uvec2 mask = uvec2(world.words[brick + 2u * tile], world.words[brick + 2u * tile + 1u]);
    rx_looked_mask = mask;
    uint bit = rx_mask_bit(c);
    if (!rx_mask_has(mask, bit)) {
        log2_free = rx_mask_free(mask, bit);
        return 0u;
    }
    log2_free = 0u;
    return rx_brick_material(brick, tile, mask, bit);
}

#include <raxel/internal/trace.glsl>
