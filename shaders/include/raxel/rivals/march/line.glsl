// A ray of the marchers in plain f32: a line, in voxels from world.origin, cut to the bounds of all solids. Its rounding errors grow with
// the distance from the camera to world.origin, which is one of the reasons why those marchers are inexact.
#ifndef RAXEL_MARCH_LINE_GLSL
#define RAXEL_MARCH_LINE_GLSL

#include <raxel/internal/look.glsl>

// A marcher looks at this many cells at most, then misses. Its world may have 2^30 voxels, and software drivers of the llvmpipe
// family end every loop after 65,535 rounds.
const uint RX_MARCH_ROUNDS = 60000u;

// A ray as a line in f32.
struct RxLine {
    vec3 origin;    // voxels from world.origin
    vec3 dir;       // the ray's, scaled by a power of two so that its largest component is 1 to 2; 2 to 4 if the ray's is 2^127 or more
    vec3 inv;       // 1 / dir; 0 where dir is 0
    bvec3 still;    // dir is 0 there
    ivec3 forward;  // 1 where dir is positive, else 0
    float t;        // where it begins, in lengths of `dir`
    float t_end;    // where it ends
    float scale;    // lengths of ray.dir in one of `dir`
    uint axis;      // of the face of the bounds it comes in by; 3 if it begins inside
};

// world.origin to `cell`, in voxels, also when the difference is beyond an int.
vec3 rx_line_offset(ivec3 cell) {
    ivec3 whole = cell - world.origin;
    bvec3 wraps = lessThan((cell ^ world.origin) & (cell ^ whole), ivec3(0));
    return mix(vec3(whole), vec3(cell) - vec3(world.origin), wraps);
}

// False if the ray is not valid (NaN, infinite, zero) or never within the bounds.
bool rx_line_begin(RxRay ray, out RxLine line) {
    uint top = rx_lattice_top(ray.dir);
    bool valid = top != 0u && !rx_not_finite(ray.dir) && !rx_not_finite(ray.frac);
    line.scale = uintBitsToFloat(max(254u - top, 1u) << 23);
    line.origin = rx_line_offset(ray.cell) + ray.frac;
    line.dir = ray.dir * line.scale;
    // A component that is lost beside the largest one is none: its reciprocal would be infinite.
    line.still = lessThan(abs(line.dir), vec3(1.0e-20));
    line.inv = mix(1.0 / mix(line.dir, vec3(1.0), line.still), vec3(0.0), line.still);
    line.forward = ivec3(greaterThan(line.dir, vec3(0.0)));
    line.t = 0.0;
    line.t_end = ray.t_max >= 1.0e37 ? RX_NEVER : ray.t_max / line.scale;
    line.axis = 3u;
    vec3 low = vec3(world.bounds_min - world.origin), high = vec3(world.bounds_last - world.origin + 1);
    for (uint a = 0u; a < 3u; ++a) {
        float origin = line.origin[a];
        if (line.still[a]) {
            valid = valid && origin >= low[a] && origin < high[a];
            continue;
        }
        bool forward = line.forward[a] == 1;
        float enter = ((forward ? low[a] : high[a]) - origin) * line.inv[a];
        float leave = ((forward ? high[a] : low[a]) - origin) * line.inv[a];
        if (enter > line.t) {
            line.t = enter;
            line.axis = a;
        }
        line.t_end = min(line.t_end, leave);
    }
    return valid && line.t <= line.t_end;
}

// The cell at t, from world.origin; rounding does not bring it out of the bounds.
ivec3 rx_line_cell(RxLine line, float t) {
    ivec3 low = world.bounds_min - world.origin, high = world.bounds_last - world.origin;
    return clamp(ivec3(floor(line.origin + t * line.dir)), low, high);
}

// Whether a cell is within the bounds of the solid voxels.
bool rx_line_within(ivec3 cell) {
    ivec3 low = world.bounds_min - world.origin, high = world.bounds_last - world.origin;
    return all(greaterThanEqual(cell, low)) && all(lessThanEqual(cell, high));
}

// When the line leaves the cube of 2^shift voxels that holds `cell`, by each axis.
vec3 rx_line_exits(RxLine line, ivec3 cell, uint shift) {
    vec3 planes = vec3(((cell >> shift) + line.forward) << shift);
    return mix((planes - line.origin) * line.inv, vec3(RX_NEVER), line.still);
}

// The time at which it enters a voxel, and the axis.
float rx_line_entry(RxLine line, ivec3 cell, out uint axis) {
    vec3 planes = vec3(cell + 1 - line.forward);
    vec3 times = mix((planes - line.origin) * line.inv, vec3(-RX_NEVER), line.still);
    axis = times.x >= times.y && times.x >= times.z ? 0u : times.y >= times.z ? 1u : 2u;
    return times[axis];
}

// The axis of the least of three times.
uint rx_line_first(vec3 times) {
    return times.x <= times.y && times.x <= times.z ? 0u : times.y <= times.z ? 1u : 2u;
}

// A hit at `cell`, entered through a face of `axis` at t; axis 3 is a start inside. False beyond ray.t_max.
bool rx_line_hit(RxLine line, RxRay ray, ivec3 cell, float t, uint axis, uint material, inout RxHit hit) {
    vec3 place = clamp(line.origin + t * line.dir - vec3(cell), 0.0, 1.0);
    hit.voxel = world.origin + cell;
    hit.material = material;
    hit.t = t * line.scale;
    hit.face = axis == 3u ? RX_FACE_INSIDE : 2u * axis + uint(1 - line.forward[axis]);
    hit.uv = axis == 0u ? place.yz : axis == 1u ? place.xz : place.xy;
    return hit.t <= ray.t_max;
}

const RxHit RX_NO_HIT = RxHit(ivec3(0), 0u, 0u, 0.0, vec2(0.0), 0u);

#endif
