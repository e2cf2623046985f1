// Where lists of lamps lie in the buffers Known and Found. A fine list belongs to a cell of 16 voxels and a direction. A region's list belongs to a cube of 64 or of 256
// voxels: REGION_EACH words are a hash set, as many behind all of these sets are the number of its members and then the members in a row. The sets of what a frame has
// found are in Found at the same places. Needs <raxel/random.glsl>.
#ifndef FACE_CACHE_LAMP_LISTS_GLSL
#define FACE_CACHE_LAMP_LISTS_GLSL

const uint KNOWN_CELLS = 32768u, KNOWN_EACH = 16u;
const uint KNOWN_BITS = 27u;                        // of a word, for a place; above them, log2 of the light
const uint REGION_SIZES = 2u, REGION_CELLS = 512u, REGION_EACH = 256u;
const uint REGION_BITS = 30u;                       // of a word, for a place; above them, how lately the lamp has lit something
const uint REGION_SETS = KNOWN_CELLS * KNOWN_EACH;  // the first word of the sets
const uint REGION_ROWS = REGION_SETS + REGION_SIZES * REGION_CELLS * REGION_EACH;   // the first word of the rows

#endif
