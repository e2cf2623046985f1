// 64-bit masks of the cells of a 4^3 block that a line may pass, for each pair of places on its faces.
// shaders/rivals/march/raymask_bake.comp makes them, and raymask.glsl uses them. After the fourth of the renderers in
// docs/rivals/marchers.md, with two differences: blocks are mirrored so that lines never move down, which leaves 3 faces to come in by and 3
// to go out by instead of 30 pairs; and the masks can be made conservative.
#ifndef RAXEL_RAYMASK_TABLE_GLSL
#define RAXEL_RAYMASK_TABLE_GLSL

// A face is split into this many squares a side.
const uint RX_RAYMASK_SIDE = 16u;
const uint RX_RAYMASK_SQUARES = RX_RAYMASK_SIDE * RX_RAYMASK_SIDE;

// The margin of a conservative mask around its squares, in voxels: the largest error of the places on the faces.
const float RX_RAYMASK_MARGIN = 0.03125;

// The line enters through the low face of axis `enter`, and leaves through the high face of axis `leave`. Squares count
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
