// Where shadows have moved lately, in cells of 8 voxels that are hashed. Light that faces near them send on changes fast, while the rest of
// the world hardly changes as the sun moves. Needs the buffer `stirred`: for each cell, the number of the frame after which a shadow moved
// there last, or 0.
#include <raxel/random.glsl>

const uint STIRRED_CELLS = 32768u;
const uint STIRRED_FRAMES = 16u;   // for which a cell counts as stirred

uint stirred_place(ivec3 cell) {
    return rx_hash(uint(cell.x) + rx_hash(uint(cell.y) + rx_hash(uint(cell.z)))) & STIRRED_CELLS - 1u;
}
