// Beams find how far ahead of the camera a whole tile of pixels is free. The rays of the tile may start there, and hit the same voxels.
//
// At depth z, all rays of a tile are in a box around the central ray. The box grows with z. A beam looks at the cells that the box
// overlaps, at most two along each axis. If all are empty, it goes on to the depth where the box first reaches over their border. Every
// point of a ray on the way is in a cell that the beam looked at, so it misses nothing, however thin.
//
// Starting rays from a coarser pass is from "Efficient Sparse Voxel Octrees" (Laine and Karras, 2010). There, rays start at the least
// depth of four corner rays, which misses things between the four.
#ifndef RAXEL_BEAM_GLSL
#define RAXEL_BEAM_GLSL

#include "camera.glsl"

const float RX_BEAM_NOTHING = RX_FAR;  // no ray of the tile hits anything
const float RX_BEAM_ROOM = 0.02;       // voxels: more than any place of a beam is off by rounding, see docs/exactness.md
// Farther from world.origin, in voxels, floating point is too coarse for that room; there are no beams.
const int RX_BEAM_REACH = 1 << 14;

#ifndef RX_LAYOUT_TREE64
#include "internal/look.glsl"

// log2 of an empty aligned cube that holds cell c of the world's cube; -1 if the voxel is solid.
int rx_free(uvec3 c) {
    uint log2_free;
    return rx_look(world.origin + ivec3(c), log2_free) != 0u ? -1 : int(log2_free);
}
#endif

// Depth up to which the rays through the centres of the pixels `first` to `last` are free, in voxels along the camera's axis; or
// RX_BEAM_NOTHING. The search starts at `depth`, which must be free, and takes at most `rounds` rounds.
float rx_beam(ivec3 cell, vec3 frac, mat4 view_to_world, vec2 tan_half_fov, ivec2 first, ivec2 last, ivec2 size, float depth, int rounds) {
    ivec3 from = cell - world.origin;
    if (rx_beyond(from, RX_BEAM_REACH) || rx_wraps(cell, world.origin) || (1 << world.log2_size) > RX_BEAM_REACH) return 0.0;
    vec3 origin = vec3(from) + frac;
    vec2 pixel = 2.0 * tan_half_fov / vec2(size);
    vec2 middle = (vec2(first + last + 1) * 0.5 - vec2(size) * 0.5) * pixel;
    vec3 dir = view_to_world[0].xyz * middle.x - view_to_world[1].xyz * middle.y - view_to_world[2].xyz;
    vec2 reach = vec2(last - first) * 0.5 * pixel;
    // The last term is more than a ray of the tile, or the beam, is off in its direction.
    vec3 spread = abs(view_to_world[0].xyz) * reach.x + abs(view_to_world[1].xyz) * reach.y + 1.0e-6 * (length(dir) + reach.x + reach.y);
    // At depth z the box is from origin + z * slow to origin + z * fast.
    vec3 slow = dir - spread, fast = dir + spread;
    bvec3 sinks = lessThan(slow, vec3(0.0)), climbs = greaterThan(fast, vec3(0.0));
    vec3 inv_slow = 1.0 / min(slow, vec3(-1.0e-30)), inv_fast = 1.0 / max(fast, vec3(1.0e-30));
    vec3 low = vec3(world.bounds_min - world.origin) - 0.1, high = vec3(world.bounds_last - world.origin + 1) + 0.1;

    // Before the last slab of the bounds is touched there is nothing, nor after one of them is left for good.
    vec3 touch = max(mix(vec3(0.0), (low - origin) * inv_fast, lessThan(origin, low)),
                     mix(vec3(0.0), (high - origin) * inv_slow, greaterThan(origin, high)));
    depth = max(depth, max(touch.x, max(touch.y, touch.z)));
    vec3 leave = min(mix(vec3(RX_FAR), (high - origin) / max(slow, vec3(1.0e-30)), greaterThan(slow, vec3(0.0))),
                     mix(vec3(RX_FAR), (low - origin) / min(fast, vec3(-1.0e-30)), lessThan(fast, vec3(0.0))));
    float gone = min(leave.x, min(leave.y, leave.z));
    if (depth > 1.0e9) return RX_BEAM_NOTHING;

    ivec3 last_cell = ivec3((1 << world.log2_size) - 1);
    for (int i = 0; i < rounds; ++i) {
        if (depth >= gone) return RX_BEAM_NOTHING;
        // Outside of the cube there is nothing.
        ivec3 a = clamp(ivec3(floor(origin + depth * slow - 2.5 * RX_BEAM_ROOM)), ivec3(0), last_cell);
        ivec3 b = clamp(ivec3(floor(origin + depth * fast + 2.5 * RX_BEAM_ROOM)), ivec3(0), last_cell);
        int log2_free = rx_free(uvec3(b));
        uvec3 span = uvec3(a ^ b);
        for (uint corner = 1u; corner < 8u && log2_free >= 0; ++corner) {
            // An axis along which both ends are in the same cell needs no second look.
            uvec3 apart = span >> log2_free;
            uint axes = (apart.x != 0u ? 1u : 0u) | (apart.y != 0u ? 2u : 0u) | (apart.z != 0u ? 4u : 0u);
            if (axes == 0u) break;
            if ((corner & ~axes) != 0u) continue;
            log2_free = min(log2_free, rx_free(uvec3((corner & 1u) != 0u ? a.x : b.x, (corner & 2u) != 0u ? a.y : b.y,
                                                     (corner & 4u) != 0u ? a.z : b.z)));
        }
        if (log2_free < 0 || any(greaterThan((b >> log2_free) - (a >> log2_free), ivec3(1)))) return depth;
        a = (a >> log2_free) << log2_free;
        b = ((b >> log2_free) + 1) << log2_free;
        vec3 lower = mix(vec3(a), vec3(-RX_FAR), lessThanEqual(a, ivec3(0)));
        vec3 upper = mix(vec3(b), vec3(RX_FAR), greaterThan(b, last_cell));
        vec3 t = min(mix(vec3(RX_FAR), (lower - origin + RX_BEAM_ROOM) * inv_slow, sinks),
                     mix(vec3(RX_FAR), (upper - origin - RX_BEAM_ROOM) * inv_fast, climbs));
        // No ray is over the border before that, but the box that the next round looks at is: it looks at other cells.
        depth = max(depth, min(t.x, min(t.y, t.z)));
    }
    return depth;
}

// The depth as a time of the ray through the centre of a pixel, for rx_trace_from.
float rx_beam_time(float depth, mat4 view_to_world, vec2 tan_half_fov, ivec2 pixel, ivec2 size) {
    return depth * rx_camera_length(view_to_world, tan_half_fov, pixel, size) * 0.99999 - 0.01;
}

#endif
