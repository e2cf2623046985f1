// Traces parallel rays, a tile of 16 x 16 pixels at a time: rays from the hits of pixels to the sun, or texels of an orthographic map. One
// subgroup of 32 invocations walks the tree once for all of them, as packet.glsl does for the rays of a camera. Hits equal those of rx_trace.
// shaders/sun_tiles.comp is an example. A shader includes this file, defines rx_tile_hit and rx_tile_miss as for packet.glsl, and
//
//     bool rx_tile_near(ivec2 pixel, out ivec3 cell);                   a voxel near the start of a pixel's ray; false if it has no ray
//     bool rx_tile_start(ivec2 pixel, out ivec3 cell, out vec3 frac);   the start, as in RxRay; false if it has no ray
//
// and calls rx_trace_parallel once, from a workgroup of 32 x 1 x 1. Each pixel of the tile on the output gets one call of rx_tile_hit or
// rx_tile_miss, in any order, unless it has no ray, or its bit is set in the returned value: then trace it with rx_trace.
//
// With RX_TILE_ANY_HIT defined, rx_tile_hit only says that the ray hits something. Its voxel is one that the ray passes through, not always the
// first, and its face is RX_FACE_INSIDE. If subgroups are neither 32 nor 64 wide, or the world's layout is not tree64, all bits are set.
// `when = "device.packets"` leaves the pass out in these cases, and `subgroup = 32` asks for subgroups of 32.
//
// Seen along the direction, all rays are points, and a cube is a hexagon. The rays of a tile lie within an interval on each of three axes of
// that view, and so do the rays that can meet a cube. Two ballots collect the children of a node to visit. To find the pixels whose rays a
// voxel can stop, the voxel is moved back along the direction to the starts of the rays, and projected there. The rest is as with a camera:
// each pixel has its candidates, f32 tests them, and integers decide the cases that f32 cannot.
//
// This pays if the rays of a tile lie close together, as on level ground. On a slope, or over an edge, they start tens of voxels apart. Then the
// walk visits all surface between them, where a single ray leaves it after a few steps. So a tile whose rays are too far apart is handed on
// untouched. 32 of its pixels are checked for that first, then all of them.
#ifndef RAXEL_PARALLEL_GLSL
#define RAXEL_PARALLEL_GLSL

#include "internal/tile.glsl"

bool rx_tile_near(ivec2 pixel, out ivec3 cell);
bool rx_tile_start(ivec2 pixel, out ivec3 cell, out vec3 frac);

// Limits of a tile, beyond which its rays are handed on. A shader can define others.
#ifndef RX_PARALLEL_NEAR
#define RX_PARALLEL_NEAR 25.0   // of rx_parallel_area for the 32 pixels
#endif
#ifndef RX_PARALLEL_AREA
#define RX_PARALLEL_AREA 25.0   // for all of its rays
#endif
#ifndef RX_PARALLEL_LEAVES
#define RX_PARALLEL_LEAVES 32u  // leaves that are looked at
#endif

#ifdef RX_LAYOUT_TREE64
#include "internal/parallel.glsl"
#endif

// `view` of rx_trace_parallel for rays that begin where those of a camera hit; view_cell and view_frac are the camera's.
void rx_camera_view(mat4 view_to_world, vec2 tan_half_fov, ivec2 size, out vec4 view[3]) {
    vec2 per_voxel = 0.5 * vec2(size) / tan_half_fov, middle = 0.5 * vec2(size - 1);
    vec3 right = view_to_world[0].xyz, up = view_to_world[1].xyz, ahead = -view_to_world[2].xyz;
    view[0] = vec4(right * per_voxel.x + middle.x * ahead, 0.0);
    view[1] = vec4(-up * per_voxel.y + middle.y * ahead, 0.0);
    view[2] = vec4(ahead, 0.0);
}

// `view`: from a place relative to view_cell and view_frac, (x, y, z, 1), three dot products give (u w, v w, w), with w at least 1 where rays begin: the ray
// of pixel (u, v) begins there, whole numbers being the middles of pixels. rx_camera_view tells them for a camera. A ray that does not begin where they say, to
// 1/128 of a pixel, is handed on.
uint rx_trace_parallel(ivec2 tile, ivec2 size, vec3 dir, ivec3 view_cell, vec3 view_frac, vec4 view[3]) {
#ifdef RX_LAYOUT_TREE64
    const uvec3 lattice = rx_tile_lattice(dir);
    const vec3 d = vec3(lattice) * 9.31322574615478515625e-10;  // exactly
    const RxTileOctant octant = rx_tile_octant(rx_set_of(lessThan(dir, vec3(0.0))) & rx_set_of(notEqual(lattice, uvec3(0u))));
    if (rx_parallel_apart(tile, size, octant, d)) return rx_tile_on_output(tile, size);

    ivec3 cells[8];
    vec3 fracs[8];
    uint rest = 0u;  // bit s: this invocation's pixel of group s has a ray that is handed on
    for (uint s = 0u; s < 8u; ++s) {
        ivec2 pixel = rx_tile_pixel(tile, s);
        if (all(lessThan(pixel, size)) && rx_tile_start(pixel, cells[s], fracs[s])) rest |= 1u << s;
    }
    bool proven = RX_TILE_IN_STEP && (1 << world.log2_size) <= RX_TILE_REACH && !rx_not_finite(dir) && (lattice.x | lattice.y | lattice.z) != 0u;
    uint some = RX_TILE_BALLOT(rest != 0u);
    if (!proven || some == 0u) return rest;
    if (gl_LocalInvocationIndex == uint(findLSB(some))) rx_parallel_anchor = cells[findLSB(rest)];
    barrier();
    const RxParallel rays = RxParallel(lattice, d, 1.0 / max(d, vec3(1.0e-10)), rx_parallel_anchor);
    if (rx_beyond(rays.anchor - world.origin, RX_TILE_REACH) || rx_wraps(rays.anchor, world.origin)) return rest;
    rx_parallel_frame(tile, octant, rays, view_cell, view_frac, view);
    barrier();

    uint alive = 0u;  // bit s: the ray of this invocation's pixel of group s is traced and has not hit anything yet
    for (uint s = 0u; s < 8u; ++s) {
        if (((rest >> s) & 1u) != 0u && rx_parallel_take(octant, rays, s, cells[s], fracs[s])) alive |= 1u << s;
    }
    if (!RX_TILE_ANY(alive != 0u)) return rest;
    RxParallelBounds bounds = rx_parallel_measure(alive, d);
    if (rx_parallel_area(bounds.most - bounds.least, d) > RX_PARALLEL_AREA) return rest;

    rest &= ~alive;
    RxParallelWalk walk = rx_parallel_walk(tile, octant, rays, bounds, alive, rest);
    if (walk.too_much) return rest | walk.alive;
    for (uint missed = walk.alive; missed != 0u; missed &= missed - 1u) rx_tile_miss(rx_tile_pixel(tile, uint(findLSB(missed))));
    return rest;
#else
    uint rest = 0u;
    for (uint s = 0u; s < 8u; ++s) {
        ivec3 cell;
        vec3 frac;
        ivec2 pixel = rx_tile_pixel(tile, s);
        if (all(lessThan(pixel, size)) && rx_tile_start(pixel, cell, frac)) rest |= 1u << s;
    }
    return rest;
#endif
}

#endif
