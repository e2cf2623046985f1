// Traces camera rays, a tile of 16 x 16 pixels at a time: one subgroup of 32 invocations walks the tree once for all rays of the tile. Hits
// equal those of rx_trace. A shader includes this file and defines
//
//     void rx_tile_hit(ivec2 pixel, ivec3 voxel, uint face);
//     void rx_tile_miss(ivec2 pixel);
//     void rx_tile_rest(ivec2 pixel, float t_free);   undecided: trace this pixel with rx_trace_from
//
// and calls rx_trace_tile once, from a workgroup of 32 x 1 x 1. Each pixel of the tile on the output gets exactly one of these calls, in any
// order. rx_hit_of computes the rest of a hit. If subgroups are neither 32 nor 64 wide, or the world's layout is not tree64, every pixel gets
// rx_tile_rest. `when = "device.packets"` leaves the pass out in these cases. `subgroup = 32` asks for subgroups of 32; of one of 64, half is idle.
//
// 1. Nodes: each invocation tests two of a node's 64 children against the frustum of the tile (intervals, conservative). Two ballots collect the
//    results. In ascending mirrored order the children are front to back for every ray of an octant. They wait on a stack, the first one on
//    top. One invocation each loads the masks of a node's leaves.
// 2. Voxels: those of a leaf's 64 voxels that the frustum touches become candidates, in order. Up to 32 at a time are projected to the rows and
//    columns of pixels that they can cover. One transposition of 32 x 32 bits gives each column and each row its set of candidates. A pixel
//    has the intersection of its column's and its row's.
// 3. Tests: each invocation goes through those of its eight pixels that have candidates, one candidate a round, as slabs in f32 with a bound on
//    the error. Cases that f32 cannot decide wait until the end, where integers decide them. The frustum shrinks to the pixels that are left.
// 4. The rest, to be traced ray by ray: what is left of a tile after too many leaves or with a full stack (with the time until which its rays
//    are free), hits of a camera in a solid voxel, and all pixels where the bounds are not proven.
#ifndef RAXEL_PACKET_GLSL
#define RAXEL_PACKET_GLSL

#include "camera.glsl"
#include "internal/tile.glsl"

void rx_tile_rest(ivec2 pixel, float t_free);

#ifdef RX_LAYOUT_TREE64
#include "internal/packet.glsl"
#endif

void rx_trace_tile(ivec2 tile, ivec3 cell, vec3 frac, mat4 view_to_world, vec2 tan_half_fov, ivec2 size) {
#ifdef RX_LAYOUT_TREE64
    RxPacket packet = RxPacket(tile, cell, frac, view_to_world, tan_half_fov, size, sqrt(1.0 + dot(tan_half_fov, tan_half_fov)));
    bool proven = rx_packet_proven(packet), one_octant;
    uint all_rays = rx_tile_on_output(tile, size), axes = rx_packet_octant(packet, one_octant);
    // Bit s: this invocation's pixel of group s is handed on, or hits nothing.
    uint rest = proven ? 0u : all_rays, missed = 0u;
    float free = 0.0;  // at depth 1, of all that are handed on
    rx_packet_views(packet);
    barrier();
    // A tile with rays in several octants is traced once for each.
    for (axes = one_octant ? axes : 0u; axes < 8u && proven; axes += one_octant ? 8u : 1u) {
        uint alive = all_rays;
        if (!one_octant) alive &= rx_packet_rays(packet, axes);
        if (!RX_TILE_ANY(alive != 0u)) continue;
        RxTileOctant octant = rx_tile_octant(axes);
        barrier();
        rx_packet_frame(packet, octant);
        barrier();
        RxPacketWalk walk = rx_packet_begin(packet, octant, alive);
        rx_packet_walk(packet, octant, walk, rest);
        if (walk.too_much) {
            float until = rx_packet_free(octant, walk);
            // A tile with rays in several octants has one time for each, and hits of a camera in a solid voxel have none.
            if (one_octant && !RX_TILE_ANY(rest != 0u)) free = until;
            rest |= walk.alive;
        } else {
            missed |= walk.alive;
        }
    }
    while (RX_TILE_ANY((missed | rest) != 0u)) {
        uint s = uint(findLSB(missed | rest)) & 7u;
        ivec2 pixel = rx_tile_pixel(tile, s);
        if (((missed >> s) & 1u) != 0u) rx_tile_miss(pixel);
        if (((rest >> s) & 1u) != 0u) {
            // At depth 1 the direction is as long as this.
            float length_of = length(rx_packet_direction(packet, s)) / rx_packet_scale(packet);
            rx_tile_rest(pixel, free * (0.999 * length_of));
        }
        missed &= ~(1u << s);
        rest &= ~(1u << s);
    }
#else
    // Packets know no other tree, but whether there is anything to hit.
    bool nothing = any(greaterThan(world.bounds_min, world.bounds_last));
    for (uint i = gl_LocalInvocationIndex; i < uint(RX_TILE * RX_TILE); i += 32u) {
        ivec2 pixel = tile * RX_TILE + ivec2(i & 15u, i >> 4);
        if (any(greaterThanEqual(pixel, size))) continue;
        if (nothing) rx_tile_miss(pixel);
        else rx_tile_rest(pixel, 0.0);
    }
#endif
}

#endif
