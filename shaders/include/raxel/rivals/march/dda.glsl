// Voxel by voxel: Amanatides and Woo, "A Fast Voxel Traversal Algorithm for Ray Tracing" (1987). It sums the
// times of crossings in f32, so their error grows with each voxel. Two crossings that are close together may
// come in the wrong order.
#ifndef RAXEL_MARCH_DDA_GLSL
#define RAXEL_MARCH_DDA_GLSL

#include "line.glsl"

// From line.t to line.t_end.
bool rx_dda(RxLine line, RxRay ray, inout RxHit hit) {
    ivec3 cell = rx_line_cell(line, line.t);
    vec3 next = rx_line_exits(line, cell, 0u);  // time of the next crossing of each axis
    float t = line.t;
    uint axis = line.axis;
    for (; hit.steps < RX_MARCH_ROUNDS && t <= line.t_end && rx_line_within(cell); ++hit.steps) {
        uint log2_free;
        uint material = rx_look(world.origin + cell, log2_free);
        if (material != 0u) {
            ++hit.steps;
            return rx_line_hit(line, ray, cell, t, axis, material, hit);
        }
        axis = rx_line_first(next);
        t = next[axis];
        next[axis] += abs(line.inv[axis]);
        cell[axis] += 2 * line.forward[axis] - 1;
    }
    return false;
}

#ifdef RX_MARCH_DDA
// First solid voxel along a ray, voxel by voxel.
bool rx_march(RxRay ray, out RxHit hit) {
    hit = RX_NO_HIT;
    RxLine line;
    return rx_line_begin(ray, line) && rx_dda(line, ray, hit);
}
#endif

#endif
