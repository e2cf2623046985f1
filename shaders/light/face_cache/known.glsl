// Lists of lamps, and the additions of a frame. A fine list belongs to a cell of 16 voxels and a direction. A region's list belongs to a
// cube of 64 or of 256 voxels. REGION_EACH words are a hash set. Behind all sets, each list has as many words again: the number of its
// members, then the members in a row. The lamps that a frame has found stand at the same places as the sets. KNOWN_ACCESS is empty where the
// shader writes the lists. Needs <raxel/random.glsl>.
#ifndef FACE_CACHE_KNOWN_GLSL
#define FACE_CACHE_KNOWN_GLSL
#ifndef KNOWN_ACCESS
#define KNOWN_ACCESS readonly
#endif

const uint KNOWN_CELLS = 32768u, KNOWN_EACH = 16u;
const uint KNOWN_BITS = 27u;                        // of a word, for a place; above them, log2 of the light
const uint REGION_SIZES = 2u, REGION_CELLS = 512u, REGION_EACH = 256u;
const uint REGION_BITS = 30u;                       // of a word, for a place; above them, how lately the lamp has lit something
const uint REGION_SETS = KNOWN_CELLS * KNOWN_EACH;  // the first word of the sets
const uint REGION_ROWS = REGION_SETS + REGION_SIZES * REGION_CELLS * REGION_EACH;   // the first word of the rows

layout(std430) buffer Known {
    KNOWN_ACCESS uvec4 known[(REGION_ROWS + REGION_SIZES * REGION_CELLS * REGION_EACH) / 4u];   // four words of a list
    uint found[REGION_ROWS];                                                                    // the additions of this frame
};

#endif
