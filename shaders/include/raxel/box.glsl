// Whether a ray may meet a box of voxels. The answer is conservative: every ray that meets the box gets "yes". So a shader can safely skip work after a "no".
#ifndef RAXEL_BOX_GLSL
#define RAXEL_BOX_GLSL

#include "internal/walk.glsl"

// The direction of a ray on the lattice, its largest component in 1 to 2; zero for a ray that hits nothing.
vec3 rx_lattice_direction(RxRay ray) {
    uint top = rx_lattice_top(ray.dir);
    if (top == 0u || rx_not_finite(ray.dir) || rx_not_finite(ray.frac)) return vec3(0.0);
    uvec3 bits = floatBitsToUint(ray.dir);
    vec3 size = vec3(rx_lattice_component(bits.x, top), rx_lattice_component(bits.y, top), rx_lattice_component(bits.z, top));
    return mix(size, -size, notEqual(bits >> 31, uvec3(0u))) * 9.31322574615478515625e-10;
}

// A lower bound of the time at which a ray enters the box of cells `low` to `last`; RX_NEVER if it misses. It is early by at most 2^-18 of the
// distance still to go, which is more than free frames turn rays.
float rx_box_time(RxRay ray, vec3 inverse, ivec3 low, ivec3 last) {
    vec3 frac = clamp(ray.frac, 0.0, 1.0);
    // Differences of any two coordinates, before they are rounded.
    bvec3 below = lessThan(low, ray.cell), above = lessThan(last, ray.cell);
    vec3 to_low = vec3(mix(uvec3(low) - uvec3(ray.cell), uvec3(ray.cell) - uvec3(low), below));
    vec3 to_last = vec3(mix(uvec3(last) - uvec3(ray.cell), uvec3(ray.cell) - uvec3(last), above));
    to_low = mix(to_low, -to_low, below) - frac;
    to_last = mix(to_last, -to_last, above) + (1.0 - frac);
    vec3 far = max(abs(to_low), abs(to_last));
    float room = (far.x + far.y + far.z) * 3.814697265625e-6 + 0.03125;
    to_low -= room;
    to_last += room;
    // On an axis without motion, the ray is inside the box all the time, or never.
    bvec3 still = equal(inverse, vec3(0.0));
    for (uint i = 0u; i < 3u; ++i) {
        if (still[i] && (to_low[i] > 0.0 || to_last[i] < 0.0)) return RX_NEVER;
    }
    vec3 a = mix(to_low * inverse, vec3(-RX_NEVER), still), b = mix(to_last * inverse, vec3(RX_NEVER), still);
    vec3 enter = min(a, b), leave = max(a, b);
    float t = max(max(enter.x, enter.y), max(enter.z, 0.0));
    return t <= min(leave.x, min(leave.y, leave.z)) ? t : RX_NEVER;
}

// A ray against many boxes that lie in one box: the test of each takes fewer steps than rx_box_time.
struct RxBoxes {
    vec3 inverse;  // one over the direction, RX_NEVER on an axis that the ray does not move along
    float room;    // voxels by which each box is widened against rounding; negative if the boxes are too far away for the test
};

// `low` and `last` are the cells of the box around all. Times count in lengths of `dir`.
RxBoxes rx_boxes(RxRay ray, vec3 dir, ivec3 low, ivec3 last) {
    const int REACH = 0x20000000;
    ivec3 to_low = low - ray.cell, to_last = last - ray.cell;
    bool near = !rx_wraps(low, ray.cell) && !rx_wraps(last, ray.cell) && !rx_beyond(to_low, REACH) && !rx_beyond(to_last, REACH);
    near = near && all(greaterThanEqual(ray.frac, vec3(0.0))) && all(lessThanEqual(ray.frac, vec3(1.0)));
    vec3 far = vec3(max(abs(to_low), abs(to_last)) + 1);
    // As in rx_box_time, for the farthest place.
    float room = near ? (far.x + far.y + far.z) * 3.814697265625e-6 + 0.03125 : -1.0;
    return RxBoxes(mix(1.0 / dir, vec3(RX_NEVER), equal(dir, vec3(0.0))), room);
}

// As rx_box_time, for one of these boxes. 0 if they are too far away for the test.
float rx_boxes_time(RxBoxes boxes, RxRay ray, ivec3 low, ivec3 last) {
    vec3 a = (vec3(low - ray.cell) - ray.frac - boxes.room) * boxes.inverse;
    vec3 b = (vec3(last - ray.cell) - ray.frac + (1.0 + boxes.room)) * boxes.inverse;
    vec3 enter = min(a, b), leave = max(a, b);
    float t = max(max(enter.x, enter.y), max(enter.z, 0.0));
    bool met = t <= min(leave.x, min(leave.y, leave.z));
    return boxes.room < 0.0 ? 0.0 : met ? t : RX_NEVER;
}

// Whether a ray may come within `margin` voxels of a box of voxels, from its smallest one to one past its largest. True for every such ray, and
// for some that pass up to 1/16 voxel and 2^-17 of the distance further away. Ignores t_max.
bool rx_crosses_box(RxRay ray, ivec3 low, ivec3 end, int margin) {
    vec3 dir = rx_lattice_direction(ray);
    if (dir == vec3(0.0) || any(lessThanEqual(end, low))) return false;
    // Within the range of coordinates.
    ivec3 first = max(low, ivec3(-2147483647 - 1 + margin)) - margin, last = min(end - 1, ivec3(2147483647 - margin)) + margin;
    return rx_box_time(ray, mix(1.0 / dir, vec3(0.0), equal(dir, vec3(0.0))), first, last) < RX_NEVER;
}

#endif
