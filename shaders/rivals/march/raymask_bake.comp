// Makes the table of <raxel/rivals/march/raymask_table.glsl>: a thread a pair of squares. It runs in the first frame only.
//
// With RX_RAYMASK_CONSERVATIVE = 1, a mask holds all cells on any line between the two squares. With 0, it holds the
// cells on the line between their centres.
#version 460
#include <raxel/rivals/march/raymask_table.glsl>

layout(local_size_x = 64) in;
layout(std430) writeonly buffer RxRayMasks {
    uvec2 masks[];
} rayMasks;

// Between the squares, at s from 0 to 1, lines fill the box from `low` to `high`, which move evenly. The part of s for which the box
// meets [cell, cell + 1] on one axis: x to y, empty if x > y.
vec2 meets(float low_0, float low_1, float high_0, float high_1, float cell) {
    vec2 part = vec2(0.0, 1.0);
    // low(s) <= cell + 1
    float slope = low_1 - low_0, room = cell + 1.0 - low_0;
    if (slope > 0.0) part.y = min(part.y, room / slope);
    else if (slope < 0.0) part.x = max(part.x, room / slope);
    else if (room < 0.0) part.x = 2.0;
    // high(s) >= cell
    slope = high_1 - high_0;
    room = cell - high_0;
    if (slope > 0.0) part.x = max(part.x, room / slope);
    else if (slope < 0.0) part.y = min(part.y, room / slope);
    else if (room > 0.0) part.x = 2.0;
    return part;
}

void main() {
    uint index = gl_GlobalInvocationID.x;
    if (index >= 9u * RX_RAYMASK_SQUARES * RX_RAYMASK_SQUARES) return;
    uint leave_square = index % RX_RAYMASK_SQUARES, rest = index / RX_RAYMASK_SQUARES;
    uint enter_square = rest % RX_RAYMASK_SQUARES, pair = rest / RX_RAYMASK_SQUARES;
    vec3 from = rx_raymask_middle(pair / 3u, 0.0, enter_square), to = rx_raymask_middle(pair % 3u, 4.0, leave_square);
#if RX_RAYMASK_CONSERVATIVE
    vec3 half_size = vec3(2.0 / float(RX_RAYMASK_SIDE) + RX_RAYMASK_MARGIN);
    const float slack = 1.0e-5;  // for the rounding of s
#else
    vec3 half_size = vec3(0.0);
    const float slack = 0.0;
#endif
    vec2 parts[12];
    for (uint axis = 0u; axis < 3u; ++axis) {
        for (uint cell = 0u; cell < 4u; ++cell) {
            parts[4u * axis + cell] = meets(from[axis] - half_size[axis], to[axis] - half_size[axis], from[axis] + half_size[axis],
                                            to[axis] + half_size[axis], float(cell));
        }
    }
    uvec2 mask = uvec2(0u);
    for (uint cell = 0u; cell < 64u; ++cell) {
        vec2 x = parts[cell & 3u], z = parts[4u * 2u + ((cell >> 2) & 3u)], y = parts[4u + (cell >> 4)];
        bool passed = max(x.x, max(y.x, z.x)) <= min(x.y, min(y.y, z.y)) + slack;
        if (passed) mask[cell >> 5] |= 1u << (cell & 31u);
    }
    rayMasks.masks[index] = mask;
}
