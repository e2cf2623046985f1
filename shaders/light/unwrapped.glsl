// Faces that are wide enough on the picture have a block of 4 x 4 texels of floats. Blocks are given out in turn, and a face whose block has gone to another
// one has none. UNWRAPPED_ACCESS is empty where the shader gives them out.
#ifndef UNWRAPPED_ACCESS
#define UNWRAPPED_ACCESS readonly
#endif

layout(std430) UNWRAPPED_ACCESS buffer Unwrapped {
    uint block_of[1048576];   // of each slot of the table of faces, plus one; 0 is none
    uint slot_of[65536];      // of each block, plus one
    uint given;               // blocks so far
} unwrapped;

const uint BLOCKS = 65536u;
const uint NO_BLOCK = 0xffffffffu;

uint block_of(uint slot) {
    uint block = unwrapped.block_of[slot] - 1u;
    return block < BLOCKS && unwrapped.slot_of[block] == slot + 1u ? block : NO_BLOCK;
}

uint texel_in(uint block, vec2 uv) {
    uvec2 at = min(uvec2(uv * 4.0), uvec2(3u));
    return 16u * block + at.x + 4u * at.y;
}
