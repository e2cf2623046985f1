// Finds how far rays of one origin are free together, conservatively, so that each ray can start from there.
// For every layout with looks at cells.
//
// A bundle goes cube by cube along the steepest axis of its rays. It takes the box around its rays within a cube's depth, and widens it by all
// rounding errors. This box must lie in empty cubes.
#ifndef RAXEL_MARCH_BUNDLE_GLSL
#define RAXEL_MARCH_BUNDLE_GLSL

#include "pyramid.glsl"

const uint RX_BUNDLE_RAYS = 4u;
const uint RX_BUNDLE_ROUNDS = 256u;
const float RX_BUNDLE_EMPTY = RX_FAR;      // its rays hit nothing
const float RX_BUNDLE_FAR = 16777216.0;    // cameras farther than this from world.origin get no start

// The axis of the largest component; the first of equal ones.
uint rx_steepest(vec3 dir) {
    vec3 size = abs(dir);
    return size.x >= size.y && size.x >= size.z ? 0u : size.y >= size.z ? 1u : 2u;
}

// Whether a ray can hit anything: it is finite, and its direction has a length.
bool rx_ray_is_valid(RxRay ray) {
    return rx_lattice_top(ray.dir) != 0u && !rx_not_finite(ray.dir) && !rx_not_finite(ray.frac);
}

// Whether there may be something solid in the cubes `first` to `last` (cubes of 2^level voxels, from world.origin).
bool rx_bundle_meets(ivec3 first, ivec3 last, uint level, inout uint looks) {
    int cubes = 1 << (world.log2_size - level);
    for (int z = max(first.z, 0); z <= min(last.z, cubes - 1); ++z) {
        for (int y = max(first.y, 0); y <= min(last.y, cubes - 1); ++y) {
            for (int x = max(first.x, 0); x <= min(last.x, cubes - 1); ++x) {
                ++looks;
                if (rx_occupied(world.origin + (ivec3(x, y, z) << level), level)) return true;
            }
        }
    }
    return false;
}

// The distance that is free for all rays, in voxels along their steepest axis: 0 if it is unknown, RX_BUNDLE_EMPTY if all rays are free for
// ever. The rays must have the same origin. `looks` counts cubes looked at.
float rx_bundle_free(RxRay rays[RX_BUNDLE_RAYS], out uint looks) {
    looks = 0u;
    uint a = rx_steepest(rays[0].dir);
    uint b = (a + 1u) % 3u, c = (a + 2u) % 3u;
    bool down = rays[0].dir[a] < 0.0;
    vec2 low = vec2(2.0), high = vec2(-2.0);  // slopes along b and c
    for (uint i = 0u; i < RX_BUNDLE_RAYS; ++i) {
        vec3 dir = rays[i].dir;
        if (!rx_ray_is_valid(rays[i]) || rx_steepest(dir) != a || (dir[a] < 0.0) != down) return 0.0;
        vec2 slope = vec2(dir[b], dir[c]) / abs(dir[a]);
        low = min(low, slope);
        high = max(high, slope);
    }

    if (any(greaterThan(abs(rx_line_offset(rays[0].cell)), vec3(RX_BUNDLE_FAR)))) return 0.0;
    ivec3 base = rays[0].cell - world.origin;
    vec3 frac = clamp(rays[0].frac, 0.0, 1.0);
    vec2 place = vec2(frac[b], frac[c]);
    float to_plane = down ? frac[a] : 1.0 - frac[a];  // the first one of axis a
    // Along a, as if the rays went up: the cell they begin in, and the world's end.
    int size = 1 << world.log2_size;
    int start = down ? size - 1 - base[a] : base[a];
    int at = max(start, 0);  // all cells before are empty
    uint level = min(world.log2_size, 6u);
    for (uint round = 0u; at < size; ++round) {
        int next = ((at >> level) + 1) << level;
        float near = at == start ? 0.0 : float(at - start - 1) + to_plane, far = float(next - start - 1) + to_plane;
        if (round == RX_BUNDLE_ROUNDS) return near;
        vec2 from = place + min(near * low, far * low), to = place + max(near * high, far * high);
        vec2 room = (max(abs(from), abs(to)) + far + 1.0) * RX_WALK_ERROR;
        ivec2 first_side = (ivec2(base[b], base[c]) + ivec2(floor(from - room))) >> level;
        ivec2 last_side = (ivec2(base[b], base[c]) + ivec2(floor(to + room))) >> level;
        // Wider than its cubes: the rays have come too far apart.
        if (any(greaterThan(last_side - first_side, ivec2(2)))) return near;
        ivec3 first, last;
        first[a] = last[a] = (down ? size - 1 - at : at) >> level;
        first[b] = first_side.x;
        last[b] = last_side.x;
        first[c] = first_side.y;
        last[c] = last_side.y;
        if (!rx_bundle_meets(first, last, level, looks)) {
            at = next;
            if (level < world.log2_size && ((next >> level) & 1) == 0) ++level;
        } else if (level == 0u) {
            return near;
        } else {
            --level;
        }
    }
    return RX_BUNDLE_EMPTY;
}

// The time up to which a ray of the bundle is free, for rx_trace_from.
float rx_bundle_time(RxRay ray, float free) {
    return free / abs(ray.dir[rx_steepest(ray.dir)]);
}

#endif
