// DDA over the levels of a pyramid, recursion without a stack. The march enters an occupied cube and leaves an empty one. If it leaves larger
// cubes at once, it goes on at the level of the largest. Each step computes its place from t: it needs no state of the level above, and errors
// do not add up. But a place within rounding of an edge may be taken for the wrong side.
#ifndef RAXEL_MARCH_STACKLESS_GLSL
#define RAXEL_MARCH_STACKLESS_GLSL

#include "pyramid.glsl"

// The next cell, if the line leaves the cube of 2^level voxels around `cell` at t through the face of `axis`.
ivec3 rx_line_next(RxLine line, ivec3 cell, uint level, float t, uint axis) {
    ivec3 low = (cell >> level) << level, high = low + (1 << level) - 1;
    ivec3 next = clamp(ivec3(floor(line.origin + t * line.dir)), low, high);
    next[axis] = line.forward[axis] == 1 ? high[axis] + 1 : low[axis] - 1;
    return next;
}

// First solid voxel along a ray; each step finds its level again.
bool rx_march(RxRay ray, out RxHit hit) {
    hit = RX_NO_HIT;
    RxLine line;
    if (!rx_line_begin(ray, line)) return false;
    ivec3 cell = rx_line_cell(line, line.t);
    float t = line.t;
    uint axis = line.axis, level = world.log2_size;
    while (hit.steps < RX_MARCH_ROUNDS && t <= line.t_end && rx_line_within(cell)) {
        ++hit.steps;
        if (rx_occupied(world.origin + cell, level)) {
            if (level == 0u) return rx_line_hit(line, ray, cell, t, axis, rx_material(world.origin + cell), hit);
            --level;
            continue;
        }
        vec3 exits = rx_line_exits(line, cell, level);
        axis = rx_line_first(exits);
        t = exits[axis];
        ivec3 next = rx_line_next(line, cell, level, t, axis);
        ivec3 changed = cell ^ next;
        level = min(uint(findMSB(changed.x | changed.y | changed.z)), world.log2_size);
        cell = next;
    }
    return false;
}

#endif
