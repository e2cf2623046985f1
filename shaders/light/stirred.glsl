// Where shadows and instances have moved lately, in cells that are hashed. Light near them changes fast, while the rest of the world hardly
// changes. Needs the buffer `stirred`: for each cell, the number of the frame after which something moved there last, or 0.
#include <raxel/random.glsl>

const uint STIRRED_CELLS = 65536u;
const uint STIRRED_FRAMES = 16u;   // for which a cell counts as stirred

// Of a cell of 8 voxels: shadows as the sun moves.
uint stirred_place(ivec3 cell) {
    return rx_hash(uint(cell.x) + rx_hash(uint(cell.y) + rx_hash(uint(cell.z)))) & STIRRED_CELLS - 1u;
}

// Of a wider cell: instances and their shadows. Level 0 has cells of 32 voxels, each other one cells four times as wide.
const uint STIRRED_LEVELS = 3u;

uint stirred_shift(uint level) {
    return 5u + 2u * level;
}

uint stirred_wide_place(ivec3 cell, uint level) {
    return stirred_place(ivec3(cell.xy, cell.z ^ int(level + 1u) << 28));
}
