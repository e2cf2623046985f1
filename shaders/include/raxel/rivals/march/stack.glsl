// DDA over the levels of a pyramid, recursion with a stack. A second DDA goes over the eight parts of an occupied cube. When it leaves the
// cube, the DDA of the cube's own level goes on from the stack. Each level adds up its own errors. If they leave a part and its cube through
// different faces, the march goes on beside the line.
#ifndef RAXEL_MARCH_STACK_GLSL
#define RAXEL_MARCH_STACK_GLSL

#include "pyramid.glsl"

// Levels on the stack; of larger worlds the cubes of the highest of them are gone through one by one.
const uint RX_MARCH_LEVELS = 12u;

// The walk over one level: a cube, in cubes of its level, and when the line crosses the next plane of each axis.
struct RxLevel {
    ivec3 cube;
    vec3 next;
};

// The walk of a level at a cell.
RxLevel rx_level_at(RxLine line, ivec3 cell, uint level) {
    return RxLevel(cell >> level, rx_line_exits(line, cell, level));
}

// First solid voxel along a ray, with the walks of the levels above on a stack.
bool rx_march(RxRay ray, out RxHit hit) {
    hit = RX_NO_HIT;
    RxLine line;
    if (!rx_line_begin(ray, line)) return false;
    RxLevel stack[RX_MARCH_LEVELS];  // of the levels above
    uint top = min(world.log2_size, RX_MARCH_LEVELS), level = top;
    float t = line.t;
    uint axis = line.axis;
    ivec3 first = world.bounds_min - world.origin, last = world.bounds_last - world.origin;
    RxLevel here = rx_level_at(line, rx_line_cell(line, t), level);
    while (hit.steps < RX_MARCH_ROUNDS && t <= line.t_end) {
        ++hit.steps;
        ivec3 corner = here.cube << level;
        if (rx_occupied(world.origin + corner, level)) {
            if (level == 0u) return rx_line_hit(line, ray, corner, t, axis, rx_material(world.origin + corner), hit);
            // Into it, where the line is now.
            ivec3 end = corner + (1 << level) - 1;
            ivec3 cell = clamp(ivec3(floor(line.origin + t * line.dir)), corner, end);
            if (t > line.t) cell[axis] = line.forward[axis] == 1 ? corner[axis] : end[axis];
            stack[level - 1u] = here;
            --level;
            here = rx_level_at(line, cell, level);
            continue;
        }
        // On by one cube; out of the larger one that it leads out of, and on from there.
        for (bool left = true; left;) {
            axis = rx_line_first(here.next);
            t = here.next[axis];
            here.next[axis] += abs(line.inv[axis]) * float(1u << level);
            here.cube[axis] += 2 * line.forward[axis] - 1;
            left = level < top && (here.cube >> 1) != stack[level].cube;
            if (left) here = stack[level++];
        }
        if (any(lessThan(here.cube, first >> level)) || any(greaterThan(here.cube, last >> level))) return false;
    }
    return false;
}

#endif
