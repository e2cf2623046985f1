// Which cells of a block of 4^3 a line may pass, for each pair of places on its faces: 64-bit masks, made by
// shaders/rivals/march/raymask_bake.comp and used by raymask.glsl. After the fourth of the renderers in docs/rivals/marchers.md, with two
// differences: blocks are mirrored so that lines never move down, which leaves 3 faces to come in by and 3 to go out by instead
// of 30 pairs; and the masks can be made conservative.
#ifndef RAXEL_RAYMASK_TABLE_GLSL
#define RAXEL_RAYMASK_TABLE_GLSL

// A face is split into this many squares a side.
const uint RX_RAYMASK_SIDE = 16u;
const uint RX_RAYMASK_SQUARES = RX_RAYMASK_SIDE * RX_RAYMASK_SIDE;

// Voxels by which a conservative mask is wider than its squares: the largest error of the places on the faces.
const float RX_RAYMASK_MARGIN = 0.03125;

// `enter`: axis of the low face by which the line comes in; `leave`: axis of the high face by which it goes out; squares count
// along the other two axes in the order x, y, z.
uint rx_raymask_index(uint enter, uint enter_square, uint leave, uint leave_square) {
    return ((3u * enter + leave) * RX_RAYMASK_SQUARES + enter_square) * RX_RAYMASK_SQUARES + leave_square;
}

// The square that holds a place, in voxels from the block's corner.
uint rx_raymask_square(vec3 place, uint axis) {
    vec2 on_face = axis == 0u ? place.yz : axis == 1u ? place.xz : place.xy;
    uvec2 square = uvec2(clamp(on_face * (float(RX_RAYMASK_SIDE) / 4.0), 0.0, float(RX_RAYMASK_SIDE) - 1.0));
    return square.x + RX_RAYMASK_SIDE * square.y;
}

// The centre of a square on the low (0) or high (4) face.
vec3 rx_raymask_middle(uint axis, float plane, uint square) {
    vec2 on_face = (vec2(square % RX_RAYMASK_SIDE, square / RX_RAYMASK_SIDE) + 0.5) * (4.0 / float(RX_RAYMASK_SIDE));
    return axis == 0u ? vec3(plane, on_face) : axis == 1u ? vec3(on_face.x, plane, on_face.y) : vec3(on_face, plane);
}

#endif
