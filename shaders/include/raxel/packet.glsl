// Traces camera rays, a tile of 16 x 16 pixels at a time: one subgroup of 32 invocations walks the tree once for all rays of the tile. Hits
// equal those of rx_trace. A shader includes this file and defines
//
//     void rx_tile_hit(ivec2 pixel, ivec3 voxel, uint face);
//     void rx_tile_miss(ivec2 pixel);
//     void rx_tile_rest(ivec2 pixel, float t_free);   undecided: trace this pixel with rx_trace_from
//
// and calls rx_trace_tile once, from a workgroup of 32 x 1 x 1. Each pixel of the tile on the output gets exactly one of these calls, in
// any order. rx_hit_of computes the rest of a hit. If subgroups are not 32 or 64 wide, or the world's layout is not tree64, every pixel
// gets rx_tile_rest. `when = "device.packets"` leaves the pass out in these cases. `subgroup = 32` asks for subgroups of 32; of one of 64,
// half is idle.
//
// 1. Nodes: each invocation tests two of a node's 64 children against the frustum of the tile (intervals, conservative). Two ballots collect the
//    results. In ascending mirrored order the children are front to back for every ray of an octant. They wait on a stack, the first one on
//    top. One invocation each loads the masks of a node's leaves.
// 2. Voxels: those of a leaf's 64 voxels that the frustum touches become candidates, in order. Up to 32 at a time are projected to the rows and
//    columns of pixels that they can cover. One transposition of 32 x 32 bits gives each column and each row its set of candidates. A pixel
//    has the intersection of its column's and its row's.
// 3. Tests: each invocation goes through its pixels with candidates (at most eight), one candidate a round, as slabs in f32 with a bound on the
//    error. Cases that f32 cannot decide wait until the end, where integers decide them. The frustum shrinks to the pixels that are left.
// 4. The rest is traced ray by ray: pixels that remain after too many leaves or with a full stack (with the time until which their rays are
//    free); hits of a camera in a solid voxel; and all pixels for which the bounds are not proven.
#ifndef RAXEL_PACKET_GLSL
#define RAXEL_PACKET_GLSL

#include "camera.glsl"
#include "internal/tile.glsl"

// Defined by the shader. Takes a pixel that is undecided: its ray passes only air until `t_free`, in lengths of its direction.
void rx_tile_rest(ivec2 pixel, float t_free);

// The point in each pixel through which its ray goes, in pixels from the top left. A shader can define another place, the same for all pixels.
#ifndef RX_TILE_PLACE
#define RX_TILE_PLACE vec2(0.5)
#endif
// Leaves that a tile may look at before its rays are handed on. A shader can define another number.
#ifndef RX_TILE_LEAVES
#define RX_TILE_LEAVES 112u
#endif
const uint RX_TILE_STACK = 32u;                  // nodes that may wait, a power of two and at most one for each invocation
const float RX_TILE_LATTICE = 3.7252902984619140625e-9;  // 2^-28, of the longest direction: four times the loss of a component by the lattice
const float RX_TILE_SCALE = 16384.0;             // largest distance from the centre, in pixels, of a place one voxel aside and one voxel deep

// The stack of nodes to visit, as bits. Each has the place of its corner less RX_TILE_SLACK, relative to the origin; its index; the height of its
// children from bit 28 on; and RX_TILE_FULL.
shared uvec4 rx_tile_stack[RX_TILE_STACK];
// Bits of the time at depth 1 until which the rest of a tile is free.
shared uint rx_tile_free;
// Direction through the first pixel, its change for a pixel to the right and one down (and the widening of bounds of a direction), fraction
// of the origin; all in mirrored axes.
shared vec4 rx_tile_frame[4];
// The common part of all directions of pixels, and the lattice's part in the error of a time.
shared vec4 rx_tile_camera;
// Places of columns and rows of pixels in view space, see rx_camera_direction.
shared float rx_tile_views[32];

// Without the layers that are not ahead of the origin on some axis.
uvec2 rx_tile_ahead(uvec2 mask, vec3 corner, bool down_x, bool down_y, bool down_z) {
    uvec3 past = uvec3(clamp(-corner, vec3(0.0), vec3(4.0)));
    uint x = (down_x ? 0xfu >> past.x : (0xfu << past.x) & 0xfu) * 0x11111111u;
    uint z = down_z ? 0xffffu >> (4u * past.z) : (0xffffu << (4u * past.z)) & 0xffffu;
    z |= z << 16;
    uint nearest = down_y ? 0xffff0000u : 0x0000ffffu;
    mask &= uvec2(x & z);
    if (past.y > 0u) mask.x &= ~nearest;
    if (past.y > 1u) mask.x = 0u;
    if (past.y > 2u) mask.y &= ~nearest;
    if (past.y > 3u) mask.y = 0u;
    return mask;
}

// The whole numbers of a place that the origin's fraction was taken from.
ivec3 rx_tile_cell(vec3 place) {
    precise vec3 rounded = (place + rx_tile_frame[3].xyz) + RX_ROUND;
    return floatBitsToInt(rounded) - 0x4b400000;
}

// The frustum of the pixels `rect` (first and last, from the tile's first) as intervals of 1 / direction.
void rx_tile_frustum(ivec4 rect, out vec3 slow, out vec3 fast) {
    float slack = rx_tile_frame[1].w;
    // Half of the sum and of the difference of first and last.
    vec2 to = vec2(rect.zw), from = vec2(rect.xy), middle = 0.5 * (to + from), side = 0.5 * (to - from);
    vec3 right = rx_tile_frame[1].xyz, up = rx_tile_frame[2].xyz;
    vec3 at = fma(vec3(middle.x), right, fma(vec3(middle.y), up, rx_tile_frame[0].xyz));
    vec3 by = fma(vec3(side.x), abs(right), fma(vec3(side.y), abs(up), vec3(slack)));
    vec3 most = max(at + by, vec3(slack)), least = max(at - by, vec3(1.0e-7));
    slow = (1.0 - 2.0 * RX_TILE_ERROR) / most;
    fast = (1.0 + 2.0 * RX_TILE_ERROR) / least;
}

// The earliest time, at depth 1, at which a ray of a frustum can reach a node. `at` is the node's corner less the slack.
float rx_tile_enters(vec3 at, vec3 slow) {
    return max(max(at.x * slow.x, at.y * slow.y), max(at.z * slow.z, 0.0));
}

#ifndef RX_LAYOUT_TREE64
// Calls rx_tile_rest for each pixel of a tile of 16 x 16 pixels: this layout has no packets.
void rx_trace_tile(ivec2 tile, ivec3 cell, vec3 frac, mat4 view_to_world, vec2 tan_half_fov, ivec2 size) {
    // In other layouts, packets only know whether there is anything to hit.
    bool nothing = any(greaterThan(world.bounds_min, world.bounds_last));
    for (uint i = gl_LocalInvocationIndex; i < uint(RX_TILE * RX_TILE); i += 32u) {
        ivec2 pixel = tile * RX_TILE + ivec2(i & 15u, i >> 4);
        if (any(greaterThanEqual(pixel, size))) continue;
        if (nothing) rx_tile_miss(pixel);
        else rx_tile_rest(pixel, 0.0);
    }
}
#else
// Traces the rays of the camera through a tile of 16 x 16 pixels, of an output of `size` pixels.
void rx_trace_tile(ivec2 tile, ivec3 cell, vec3 frac, mat4 view_to_world, vec2 tan_half_fov, ivec2 size) {
    const uint lane = gl_LocalInvocationIndex;
    const ivec2 first = tile * RX_TILE;
    // Group s of 8 x 4 pixels is at (s & 1, s >> 1); invocation l has its pixel l.
    const ivec2 in_group = ivec2(lane & 7u, lane >> 3);
    const uint last = (1u << world.log2_size) - 1u;
    const ivec3 from = cell - world.origin;
    const float reach = sqrt(1.0 + dot(tan_half_fov, tan_half_fov));  // the longest direction at depth 1
    const vec3 lattice_frac = floor(frac * 16777216.0) * 5.9604644775390625e-8;

    // Everything that the bounds do not hold for is handed on.
    bool proven = RX_TILE_IN_STEP && (1 << world.log2_size) <= RX_TILE_REACH && all(lessThan(frac, vec3(1.0))) && all(greaterThanEqual(frac, vec3(0.0)))
        && !rx_beyond(from, RX_TILE_REACH) && !rx_wraps(cell, world.origin)
        && all(lessThan(((0.5 / tan_half_fov + 0.5) * vec2(size) + 0.5) * reach, vec2(RX_TILE_SCALE)));
    // Bit s: this invocation's pixel of group s is on the output.
    uint all_rays;
    {
        ivec2 there = size - first - in_group;
        all_rays = (there.x > 0 ? 0x55u : 0u) | (there.x > 8 ? 0xaau : 0u);
        all_rays &= (there.y > 0 ? 0x03u : 0u) | (there.y > 4 ? 0x0cu : 0u) | (there.y > 8 ? 0x30u : 0u) | (there.y > 12 ? 0xc0u : 0u);
    }
    const float slack = 2.0 * RX_TILE_ERROR * reach;
    uint octant;
    bool one_octant;
    {
        vec2 pixel_size = 2.0 * tan_half_fov / vec2(size), start = (2.0 * RX_TILE_PLACE / vec2(size) - 1.0) * tan_half_fov;
        vec2 at = start + pixel_size * vec2(first + ivec2((lane & 1u) != 0u ? RX_TILE - 1 : 0, (lane & 2u) != 0u ? RX_TILE - 1 : 0));
        vec3 corner = view_to_world[0].xyz * at.x - view_to_world[1].xyz * at.y - view_to_world[2].xyz;
        octant = (RX_TILE_ANY(corner.x < 0.0) ? 1u : 0u) | (RX_TILE_ANY(corner.y < 0.0) ? 2u : 0u) | (RX_TILE_ANY(corner.z < 0.0) ? 4u : 0u);
        vec3 turned = mix(corner, -corner, bvec3((octant & 1u) != 0u, (octant & 2u) != 0u, (octant & 4u) != 0u));
        one_octant = !RX_TILE_ANY(min(turned.x, min(turned.y, turned.z)) < slack);
    }

    // Bit s: this invocation's pixel of group s is handed on, or hits nothing.
    uint rest = proven ? 0u : all_rays, missed = 0u;
    float free = 0.0;  // at depth 1, of all that are handed on
    precise vec2 scale = tan_half_fov * vec2(size.yx);
    precise float far_away = float(size.x) * float(size.y);
    precise vec3 back = view_to_world[2].xyz * far_away;
    // As rx_camera_direction has it.
    precise vec2 from_middle = vec2(2.0, -2.0) * (vec2(first + int(lane & 15u)) + RX_TILE_PLACE) + vec2(-size.x, size.y);
    precise float view_at = lane < 16u ? from_middle.x * scale.x : from_middle.y * scale.y;
    rx_tile_views[lane & 31u] = view_at;
    if (lane == 0u) rx_tile_camera = vec4(back, RX_TILE_LATTICE * reach * far_away);
    barrier();

    // A tile with rays in several octants is traced once for each.
    for (uint o = one_octant ? octant : 0u; o < 8u && proven; o += one_octant ? 8u : 1u) {
        const bool down_x = (o & 1u) != 0u, down_y = (o & 2u) != 0u, down_z = (o & 4u) != 0u;
        uint alive = all_rays;  // bit s: this invocation's pixel of group s has not hit anything yet
        if (!one_octant) {
            alive = 0u;
            for (uint s = 0u; s < 8u; ++s) {
                precise vec3 right = view_to_world[0].xyz * rx_tile_views[(((s & 1u) << 3) | (lane & 7u)) & 31u];
                precise vec3 up = view_to_world[1].xyz * rx_tile_views[(16u | ((s & 6u) << 1) | (lane >> 3)) & 31u];
                precise vec3 sum = right + up;
                precise vec3 dir = sum - back;
                uint there = (dir.x < 0.0 ? 1u : 0u) | (dir.y < 0.0 ? 2u : 0u) | (dir.z < 0.0 ? 4u : 0u);
                if (there == o) alive |= 1u << s;
            }
            alive &= all_rays;
        }
        if (!RX_TILE_ANY(alive != 0u)) continue;

        barrier();  // after the last read of what belongs to the octant before
        {
            vec3 sign_of = vec3(down_x ? -1.0 : 1.0, down_y ? -1.0 : 1.0, down_z ? -1.0 : 1.0);
            vec2 pixel_size = 2.0 * tan_half_fov / vec2(size);
            if (lane < 3u) {
                // The pixel of a place relative to the camera, counted from the tile's first one, in mirrored axes.
                vec3 ahead = -view_to_world[2].xyz, row = ahead, step_of = vec3(0.0);
                vec2 start = (2.0 * RX_TILE_PLACE / vec2(size) - 1.0) * tan_half_fov + pixel_size * vec2(first);
                float w = 0.0;
                if (lane == 0u) {
                    row = (view_to_world[0].xyz / pixel_size.x + (0.5 * float(size.x) - RX_TILE_PLACE.x - float(first.x)) * ahead) * 0.0625;
                    step_of = view_to_world[0].xyz * start.x - view_to_world[1].xyz * start.y - view_to_world[2].xyz;
                }
                if (lane == 1u) {
                    row = (-view_to_world[1].xyz / pixel_size.y + (0.5 * float(size.y) - RX_TILE_PLACE.y - float(first.y)) * ahead) * 0.0625;
                    step_of = view_to_world[0].xyz * pixel_size.x;
                    w = slack;
                }
                if (lane == 2u) step_of = -view_to_world[1].xyz * pixel_size.y;
                row *= sign_of;
                rx_tile_project[lane & 3u] = vec4(row, 0.5 * (row.x + row.y + row.z));
                rx_tile_project[3][lane & 3u] = 0.5 * (abs(row.x) + abs(row.y) + abs(row.z));
                rx_tile_frame[lane & 3u] = vec4(step_of * sign_of, w);
            }
            vec3 g = vec3(down_x ? 1.0 - lattice_frac.x : lattice_frac.x, down_y ? 1.0 - lattice_frac.y : lattice_frac.y, down_z ? 1.0 - lattice_frac.z : lattice_frac.z);
            if (lane == 0u) rx_tile_frame[3] = vec4(g, 0.0);
        }
        barrier();
        // Child l and child l + 32 of a node, voxel l and voxel l + 32 of a leaf are this invocation's; places in mirrored axes.
        const uvec3 child = uvec3(lane & 3u, lane >> 4, (lane >> 2) & 3u);
        const vec3 child_at = vec3(child);
        const uint child_bit = 1u << (lane ^ ((down_x ? 3u : 0u) | (down_z ? 12u : 0u) | (down_y ? 16u : 0u)));
        const uint below = (1u << lane) - 1u, child_code = child.x | (child.y << 8) | (child.z << 16);

        vec3 slow, fast, voxel_slow, voxel_fast;
        rx_tile_frustum(ivec4(0, 0, RX_TILE - 1, RX_TILE - 1), slow, fast);
        // A voxel's place in its leaf adds this to the times from and to which the frustum can be in it.
        vec3 voxel_at = child_at - rx_tile_frame[3].xyz;
        voxel_slow = (voxel_at - RX_TILE_SLACK) * slow;
        voxel_fast = (voxel_at + (1.0 + RX_TILE_SLACK)) * fast;
        uint shown = 0x0f0f0000u;  // the rectangle of pixels that are left: first column and row, last column and row
        uint looked_at = 0u, waiting = 0u;  // leaves; nodes on the stack
        bool too_much = false;
        uint id = world.root | (((world.log2_size >> 1) - 1u) << 28);
        vec3 place = -vec3(down_x ? int(last) - from.x : from.x, down_y ? int(last) - from.y : from.y, down_z ? int(last) - from.z : from.z) - (rx_tile_frame[3].xyz + RX_TILE_SLACK);
        uint ones, twos;  // children of this node that are visited: of the first half, of the second
        // Branches here are votes, though all invocations agree anyway: else the compiler keeps each condition in some ten predicates.
        for (;;) {
            // Visit a node.
            uint height = (id >> 28) & 7u;
            uvec4 node = uvec4(0xffffffffu, 0xffffffffu, 0u, RX_FILLED);
            if ((id & RX_TILE_FULL) == 0u) node = world.quads[id & 0x0fffffffu];
            uint mask_1 = down_y ? node.y : node.x, mask_2 = down_y ? node.x : node.y;
            float side = uintBitsToFloat((height << 24) + 0x3f800000u);  // 4^height
            vec3 at = fma(child_at, vec3(side), place);
            bool visit_1, visit_2;
            {
                vec3 near = at * slow, far = (at + (side + 2.0 * RX_TILE_SLACK)) * fast;
                float enter = max(max(near.x, near.z), 0.0), leave = min(far.x, far.z);
                visit_1 = max(enter, near.y) <= min(leave, far.y) && (mask_1 & child_bit) != 0u;
                visit_2 = max(enter, fma(2.0 * side, slow.y, near.y)) <= min(leave, fma(2.0 * side, fast.y, far.y)) && (mask_2 & child_bit) != 0u;
            }
            if (RX_TILE_ANY(visit_1 || visit_2)) {
                ones = RX_TILE_BALLOT(visit_1);
                twos = RX_TILE_BALLOT(visit_2);
                uint second = uint(bitCount(twos)), both = uint(bitCount(ones)) + second;
                uint half_count = uint(bitCount(node.x));
                uint child_1 = node.z + (down_y ? half_count : 0u) + uint(bitCount(mask_1 & (child_bit - 1u)));
                uint child_2 = node.z + (down_y ? 0u : half_count) + uint(bitCount(mask_2 & (child_bit - 1u)));
                bool filled = (node.w & RX_FILLED) != 0u;
                if (RX_TILE_ANY(height > 1u)) {
                    // The children go on the stack, the first one on top.
                    uint top = waiting + both, level = (id & 0x70000000u) - 0x10000000u;
                    if (RX_TILE_ANY(top > RX_TILE_STACK)) {
                        too_much = true;
                        break;
                    }
                    barrier();
                    uint slot_1 = top + ~uint(bitCount(ones & below)), slot_2 = waiting + second + ~uint(bitCount(twos & below));
                    if (visit_1) rx_tile_stack[slot_1 & (RX_TILE_STACK - 1u)] = uvec4(floatBitsToUint(at), filled ? RX_TILE_FULL | level : child_1 + level);
                    if (visit_2) rx_tile_stack[slot_2 & (RX_TILE_STACK - 1u)] = uvec4(floatBitsToUint(vec3(at.x, at.y + 2.0 * side, at.z)), filled ? RX_TILE_FULL | level : child_2 + level);
                    waiting = top;
                    barrier();
                } else {
                    looked_at += both;
                    if (RX_TILE_ANY(looked_at > RX_TILE_LEAVES)) {
                        too_much = true;
                        break;
                    }
                    // The corner of the node, exactly, in cells from the origin's.
                    precise vec3 rounded = (place + (rx_tile_frame[3].xyz + RX_TILE_SLACK)) + RX_ROUND;
                    precise vec3 corner = rounded - RX_ROUND;
                    // Masks of the leaves.
                    uvec2 leaf_1 = uvec2(0xffffffffu), leaf_2 = uvec2(0xffffffffu);
                    if (!filled) {
                        if (visit_1) leaf_1 = rx_leaf(child_1);
                        if (visit_2) leaf_2 = rx_leaf(child_2);
                    }
                    uint set = 0u;  // of the half of the node in work, leaves that are still to be looked at
                    float half_at = ones == 0u ? 0.0 : -8.0;  // where that half begins, once there is one
                    uint candidates = 0u, taken = 0u;
                    for (;;) {
                        bool more = RX_TILE_ANY((set | ones | twos) != 0u);
                        if (candidates - taken >= (more ? 32u : 1u)) {
                            barrier();  // before any invocation reads the candidates of all
                            bool some_left = true;
                            for (; candidates - taken >= (more ? 32u : 1u) && some_left; taken = min(taken + 32u, candidates)) {
                                // Candidate l is this invocation's, and bit 31 - l of a set, so that the first is the highest bit.
                                {
                                    uint code = rx_tile_candidates[(taken + lane) & 127u];
                                    // 2^23 more than each part of the code.
                                    vec3 parts = uintBitsToFloat(0x4b000000u | uvec3(code & 255u, (code >> 8) & 255u, code >> 16));
                                    precise vec3 whole = parts + (corner - 8388608.0);
                                    precise vec3 q = whole - rx_tile_frame[3].xyz;
                                    // The columns and rows of pixels that it can cover.
                                    vec4 row_x = rx_tile_project[0], row_y = rx_tile_project[1], row_z = rx_tile_project[2], half_of = rx_tile_project[3];
                                    float x = fma(row_x.x, q.x, fma(row_x.y, q.y, fma(row_x.z, q.z, row_x.w)));
                                    float y = fma(row_y.x, q.x, fma(row_y.y, q.y, fma(row_y.z, q.z, row_y.w)));
                                    float z = fma(row_z.x, q.x, fma(row_z.y, q.y, fma(row_z.z, q.z, row_z.w)));
                                    float nearest = z - half_of.z, inv_near = 1.0 / nearest, inv_far = 1.0 / (z + half_of.z);
                                    float x_1 = clamp(fma(x + half_of.x, inv_near, (0.5 + RX_TILE_MARGIN) * 0.0625), 0.0, 1.0);
                                    float x_0 = min(clamp(fma(x - half_of.x, inv_far, (0.5 - RX_TILE_MARGIN) * 0.0625), 0.0, 1.0), x_1);
                                    float y_1 = clamp(fma(y + half_of.y, inv_near, (0.5 + RX_TILE_MARGIN) * 0.0625), 0.0, 1.0);
                                    float y_0 = min(clamp(fma(y - half_of.y, inv_far, (0.5 - RX_TILE_MARGIN) * 0.0625), 0.0, 1.0), y_1);
                                    uint columns = (1u << rx_tile_sixteenths(x_1)) - (1u << rx_tile_sixteenths(x_0));
                                    uint rows = (1u << rx_tile_sixteenths(y_1)) - (1u << rx_tile_sixteenths(y_0));
                                    uint cover = columns | (rows << 16);
                                    if (nearest < 1.0) cover = 0xffffffffu;  // beside the camera
                                    rx_tile_sets(lane, taken + lane < candidates ? cover : 0u);
                                    rx_tile_corners[(31u - lane) & 31u] = vec4(q, 0.0);
                                }
                                barrier();
                                // The pixels of this invocation that have candidates.
                                uint pending = 0u;
                                for (uint i = 0u; i < 4u; ++i) {
                                    uint row = rx_tile_lists[(16u | (lane >> 3) | (i << 2)) & 31u];
                                    if ((rx_tile_lists[lane & 7u] & row) != 0u) pending |= 1u << (2u * i);
                                    if ((rx_tile_lists[8u + (lane & 7u)] & row) != 0u) pending |= 2u << (2u * i);
                                }
                                pending &= alive;
                                uint s = 0u, mine = 0u;  // the pixel of the moment, and which candidates it has left
                                bool parked = false;     // whether f32 cannot decide about the next one
                                for (;;) {
                                    while (RX_TILE_ANY((pending | mine) != 0u && !parked)) {
                                        bool fresh = mine == 0u;
                                        s = fresh ? uint(findLSB(pending)) & 7u : s;
                                        // Masked here, so that both look-ups share an address.
                                        uint column = (((s & 1u) << 3) | (lane & 7u)) & 31u, row = (16u | ((s & 6u) << 1) | (lane >> 3)) & 31u;
                                        uint set = rx_tile_lists[column & 31u] & rx_tile_lists[row & 31u];
                                        set = pending == 0u ? 0u : set;
                                        mine = fresh ? set : mine;
                                        pending &= ~(1u << s);
                                        // As rx_camera_direction has it, before it gets the length 1.
                                        vec2 view = vec2(rx_tile_views[column & 31u], rx_tile_views[row & 31u]);
                                        precise vec3 right = view_to_world[0].xyz * view.x;
                                        precise vec3 up = view_to_world[1].xyz * view.y;
                                        precise vec3 sum = right + up;
                                        precise vec3 dir = sum - rx_tile_camera.xyz;
                                        ivec2 pixel = first + ivec2(8u * (s & 1u), 4u * (s >> 1)) + in_group;
                                        vec3 inv = 1.0 / max(abs(dir), vec3(1.0e-10));
                                        // Of a time: of the direction, and of the lattice, which takes most from the smallest component.
                                        float error = fma(max(inv.x, max(inv.y, inv.z)), rx_tile_camera.w, RX_TILE_ERROR);
                                        uint c = uint(findMSB(mine)) & 31u;
                                        vec3 v = rx_tile_corners[c & 31u].xyz;
                                        // Not v * inv + inv: where that is not fused, it cancels.
                                        vec3 t_in = v * inv, t_out = (v + 1.0) * inv;
                                        float enters = max(t_in.x, max(t_in.y, t_in.z)), leaves = min(t_out.x, min(t_out.y, t_out.z));
                                        float inside = leaves - enters, limit = enters - abs(enters) * error, bound = leaves * error;
                                        bool x = t_in.x >= limit, y = t_in.y >= limit, z = t_in.z >= limit;
                                        uint axis = x ? 0u : y ? 1u : 2u;
                                        // Conditions by name: && of anything longer than a name becomes a branch.
                                        bool has = mine != 0u, ahead = enters > 0.0, near = inside >= -bound, loose = error > 0.25, certain = inside > bound;
                                        bool one = (x ? 1u : 0u) + (y ? 1u : 0u) + (z ? 1u : 0u) == 1u;
                                        bool touches = near || loose, found = has && touches, sure = certain && one, told = sure || !ahead, hit = found && told;
                                        parked = found && !told;
                                        if (hit) {
                                            alive &= ~(1u << s);
                                            ivec3 n = rx_tile_cell(v);
                                            if (ahead) rx_tile_hit(pixel, cell + ivec3(down_x ? -n.x : n.x, down_y ? -n.y : n.y, down_z ? -n.z : n.z), 2u * axis + ((o >> axis) & 1u));
                                            else rest |= 1u << s;
                                        }
                                        mine = parked ? mine : hit ? 0u : mine & ~(1u << c);
                                    }
                                    if (!RX_TILE_ANY(parked)) break;
                                    // Integers decide, seldom.
                                    if (parked) {
                                        uint c = uint(findMSB(mine)) & 31u;
                                        ivec2 pixel = first + ivec2(8u * (s & 1u), 4u * (s >> 1)) + in_group;
                                        ivec3 n = rx_tile_cell(rx_tile_corners[c & 31u].xyz);
                                        uint axis = rx_tile_settle(uvec3(n), uvec3(rx_tile_frame[3].xyz * 16777216.0), rx_tile_lattice(rx_camera_direction(view_to_world, tan_half_fov, vec2(pixel) + RX_TILE_PLACE, vec2(size))));
                                        if (axis < 3u) {
                                            alive &= ~(1u << s);
                                            rx_tile_hit(pixel, cell + ivec3(down_x ? -n.x : n.x, down_y ? -n.y : n.y, down_z ? -n.z : n.z), 2u * axis + ((o >> axis) & 1u));
                                        }
                                        mine = axis < 3u ? 0u : mine & ~(1u << c);
                                        parked = false;
                                    }
                                }
                                some_left = RX_TILE_ANY(alive != 0u);
                            }
                            if (!some_left) break;
                            // The frustum of the remaining pixels, for nodes that are still to be visited.
                            if (more || waiting != 0u) {
                                uint left = RX_TILE_BALLOT((alive & 0x55u) != 0u), right = RX_TILE_BALLOT((alive & 0xaau) != 0u);
                                uint rows_1 = RX_TILE_BALLOT((alive & 0x03u) != 0u), rows_2 = RX_TILE_BALLOT((alive & 0x0cu) != 0u);
                                uint rows_3 = RX_TILE_BALLOT((alive & 0x30u) != 0u), rows_4 = RX_TILE_BALLOT((alive & 0xc0u) != 0u);
                                left |= left >> 16;
                                right |= right >> 16;
                                uint columns = ((left | (left >> 8)) & 255u) | (((right | (right >> 8)) & 255u) << 8);
                                uint low = rows_4, first_row = 12u, high = rows_1, last_row = 0u;
                                if (rows_3 != 0u) low = rows_3, first_row = 8u;
                                if (rows_2 != 0u) low = rows_2, first_row = 4u, high = rows_2, last_row = 4u;
                                if (rows_1 != 0u) low = rows_1, first_row = 0u;
                                if (rows_3 != 0u) high = rows_3, last_row = 8u;
                                if (rows_4 != 0u) high = rows_4, last_row = 12u;
                                first_row += uint(findLSB(low)) >> 3;
                                last_row += uint(findMSB(high)) >> 3;
                                uint now = uint(findLSB(columns)) | (first_row << 8) | (uint(findMSB(columns)) << 16) | (last_row << 24);
                                if (now != shown) {
                                    shown = now;
                                    rx_tile_frustum(ivec4(now & 255u, (now >> 8) & 255u, (now >> 16) & 255u, now >> 24), slow, fast);
                                    vec3 voxel_at = child_at - rx_tile_frame[3].xyz;
                                    voxel_slow = (voxel_at - RX_TILE_SLACK) * slow;
                                    voxel_fast = (voxel_at + (1.0 + RX_TILE_SLACK)) * fast;
                                }
                            }
                        }
                        if (!more) break;
                        // A leaf: 4 x 4 x 4 voxels.
                        if (RX_TILE_ANY(set == 0u)) {
                            // The next half of the node, without voxels that no ray can hit first.
                            bool low = ones != 0u;
                            half_at += 8.0;
                            if (low) {
                                set = ones;
                                ones = 0u;
                            } else {
                                set = twos;
                                twos = 0u;
                                leaf_1 = leaf_2;
                            }
                            if (min(min(corner.x, corner.y), corner.z) < 0.0) {
                                if (down_y) leaf_1 = leaf_1.yx;
                                leaf_1 = rx_tile_ahead(leaf_1, fma(child_at, vec3(4.0), corner + vec3(0.0, half_at, 0.0)), down_x, down_y, down_z);
                            } else {
                                leaf_1 = rx_tile_bare(leaf_1, down_x, down_y, down_z);
                            }
                        }
                        uint l = uint(findLSB(set));
                        set &= set - 1u;
                        uvec2 mask = uvec2(RX_TILE_READ(leaf_1.x, l), RX_TILE_READ(leaf_1.y, l));
                        vec3 at = uintBitsToFloat(uvec3(RX_TILE_READ(floatBitsToUint(child_at.x), l), RX_TILE_READ(floatBitsToUint(child_at.y), l), RX_TILE_READ(floatBitsToUint(child_at.z), l)));
                        at = fma(at, vec3(4.0), corner + vec3(0.0, half_at, 0.0));
                        vec3 from_low = fma(at, slow, voxel_slow), to_high = fma(at, fast, voxel_fast);
                        float in_at = max(max(from_low.x, from_low.z), 0.0), out_at = min(to_high.x, to_high.z);
                        bool touch_1 = max(in_at, from_low.y) <= min(out_at, to_high.y) && (mask.x & child_bit) != 0u;
                        bool touch_2 = max(in_at, fma(2.0, slow.y, from_low.y)) <= min(out_at, fma(2.0, fast.y, to_high.y)) && (mask.y & child_bit) != 0u;
                        uint some_1 = RX_TILE_BALLOT(touch_1), some_2 = RX_TILE_BALLOT(touch_2);
                        if ((some_1 | some_2) != 0u) {
                            uint code = child_code + 4u * RX_TILE_READ(child_code, l) + (half_at == 0.0 ? 0u : 2048u);
                            if (touch_1) rx_tile_candidates[(candidates + uint(bitCount(some_1 & below))) & 127u] = code;
                            candidates += uint(bitCount(some_1));
                            if (touch_2) rx_tile_candidates[(candidates + uint(bitCount(some_2 & below))) & 127u] = code + 512u;
                            candidates += uint(bitCount(some_2));
                        }
                    }
                    if (!RX_TILE_ANY(alive != 0u)) break;
                }
            }

            // The next node.
            if (!RX_TILE_ANY(waiting != 0u)) break;
            --waiting;
            uvec4 next = rx_tile_stack[waiting & (RX_TILE_STACK - 1u)];
            place = uintBitsToFloat(next.xyz);
            id = next.w;
        }
        if (too_much) {
            // The rays that are left are free as long as none can have come to a node or leaf that is still to be visited.
            barrier();
            if (lane == 0u) rx_tile_free = 0x7f7fffffu;
            barrier();
            float side = uintBitsToFloat(((id >> 4) & 0x07000000u) + 0x3f800000u);
            vec3 at = fma(child_at, vec3(side), place);
            if (((ones >> lane) & 1u) != 0u) atomicMin(rx_tile_free, floatBitsToUint(rx_tile_enters(at, slow)));
            if (((twos >> lane) & 1u) != 0u) atomicMin(rx_tile_free, floatBitsToUint(rx_tile_enters(vec3(at.x, at.y + 2.0 * side, at.z), slow)));
            if (lane < waiting) atomicMin(rx_tile_free, floatBitsToUint(rx_tile_enters(uintBitsToFloat(rx_tile_stack[lane & (RX_TILE_STACK - 1u)].xyz), slow)));
            barrier();
            // A tile with rays in several octants has one time for each, and hits of a camera in a solid voxel have none.
            if (one_octant && !RX_TILE_ANY(rest != 0u)) free = uintBitsToFloat(rx_tile_free);
        }
        // The remaining rays hit nothing, or are handed on.
        if (too_much) rest |= alive;
        else missed |= alive;
    }
    while (RX_TILE_ANY((missed | rest) != 0u)) {
        uint s = uint(findLSB(missed | rest)) & 7u;
        ivec2 pixel = first + ivec2(8u * (s & 1u), 4u * (s >> 1)) + in_group;
        if (((missed >> s) & 1u) != 0u) rx_tile_miss(pixel);
        if (((rest >> s) & 1u) != 0u) {
            // A direction at depth 1 is as long as this.
            vec3 dir = view_to_world[0].xyz * rx_tile_views[(((s & 1u) << 3) | (lane & 7u)) & 31u] + view_to_world[1].xyz * rx_tile_views[(16u | ((s & 6u) << 1) | (lane >> 3)) & 31u] - back;
            rx_tile_rest(pixel, free * (0.999 * length(dir) / far_away));
        }
        missed &= ~(1u << s);
        rest &= ~(1u << s);
    }
}

#endif

#endif
