// Lamps near a place, whether they light it or not. Cells of 32 and of 128 voxels have a list each. It names up to 64 voxel faces of lamps in the cell and in the
// 26 cells around it, a random choice of those that there are, another one every NEAR_TURNS frames. The lists lie in the same buffers as those of
// known_lamps.glsl, behind them. Needs <raxel/random.glsl>.
#ifndef FACE_CACHE_NEAR_LAMPS_GLSL
#define FACE_CACHE_NEAR_LAMPS_GLSL

const uint KNOWN_CELLS = 32768u, KNOWN_EACH = 16u;
const uint NEAR_SIZES = 2u, NEAR_CELLS = 4096u, NEAR_EACH = 64u;
const uint NEAR_TURNS = 8u;                 // frames in which all lamps have been looked at
const uint NEAR_PLACE = (1u << 30) - 1u;    // of a word: the place from the corner of the first of those cells, 9 bits an axis, and the face; above it, how strong the lamp is, from 1 on
const int NEAR_REACH = 32;                  // cells between the camera and a lamp that is listed, at most

// log2 of the width of a cell.
int near_log2(uint size) {
    return size == 0u ? 5 : 7;
}

// The first word of a cell's list.
uint near_first(ivec3 cell, uint size) {
    return KNOWN_CELLS * KNOWN_EACH + (size * NEAR_CELLS + (rx_hash(rx_hash(cell) + size) & NEAR_CELLS - 1u)) * NEAR_EACH;
}

// The place of a voxel's face in the list of a cell, or more than NEAR_PLACE if it is too far away.
uint near_place(ivec3 voxel, uint face, ivec3 cell, uint size) {
    int log2_width = near_log2(size);
    uvec3 p = uvec3(voxel - (cell - 1 << log2_width));
    return any(greaterThanEqual(p, uvec3(3u << log2_width))) ? ~0u : p.x | p.y << 9 | p.z << 18 | face << 27;
}

ivec3 near_voxel(uint place, ivec3 cell, uint size) {
    return (cell - 1 << near_log2(size)) + ivec3(uvec3(place, place >> 9, place >> 18) & 511u);
}

uint near_slot(uint place) {
    return rx_hash(place) & NEAR_EACH - 1u;
}

// Places in an order that is another in each turn, so that the highest of several is a random one; and back.
uint near_mixed(uint place, uint turn) {
    uint mixed = place * 0x9e3779b1u & NEAR_PLACE;
    mixed ^= mixed >> 15;
    return mixed * 0x85ebca6bu + rx_hash(turn) & NEAR_PLACE;
}

uint near_plain(uint mixed, uint turn) {
    mixed = (mixed - rx_hash(turn)) * 0xa5cb9243u & NEAR_PLACE;
    mixed ^= mixed >> 15;
    return mixed * 0x0e8b2f51u & NEAR_PLACE;
}

#endif
