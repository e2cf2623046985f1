// Traces parallel rays, a tile of 16 x 16 pixels at a time: from the hits of pixels to the sun, or for an orthographic map. One
// subgroup of 32 invocations walks the tree once for all of them, as packet.glsl does for the rays of a camera. Hits equal those of rx_trace.
// shaders/sun_tiles.comp is an example. A shader includes this file, defines rx_tile_hit and rx_tile_miss as for packet.glsl, and
//
//     bool rx_tile_near(ivec2 pixel, out ivec3 cell);                   a voxel near the start of a pixel's ray; false if it has no ray
//     bool rx_tile_start(ivec2 pixel, out ivec3 cell, out vec3 frac);   the start, as in RxRay; false if it has no ray
//
// and calls rx_trace_parallel once, from a workgroup of 32 x 1 x 1. Each pixel of the tile on the output that has a ray gets one call of
// rx_tile_hit or rx_tile_miss, in any order. The exceptions are pixels whose bit is set in the returned value: trace them with rx_trace.
//
// With RX_TILE_ANY_HIT defined, rx_tile_hit only reports that the ray hits something. Its voxel is a solid one on the ray, not always the first.
// Its face is RX_FACE_INSIDE. If subgroups are not 32 or 64 wide, or the world's layout is not tree64, all bits are set.
// `when = "device.packets"` leaves the pass out in these cases, and `subgroup = 32` asks for subgroups of 32.
//
// Seen along the direction, all rays are points, and a cube is a hexagon. On each of three axes of that view, the rays of a tile lie within an
// interval, and so do the rays that can meet a cube. Two ballots collect the children of a node to visit. A voxel can stop the rays of some
// pixels. To find them, the shader moves the voxel back along the direction to the starts of the rays, and projects it there. The rest is as
// with a camera: each pixel has its candidates, f32 tests them, and integers decide the cases that f32 cannot.
//
// This pays if the rays of a tile lie close together, as on level ground. On a slope, or over an edge, they start tens of voxels apart. Then the
// walk visits all surface between them, where a single ray leaves it after a few steps. So a tile whose rays are too far apart is handed on
// untouched. 32 of its pixels are checked for that first, then all of them.
#ifndef RAXEL_PARALLEL_GLSL
#define RAXEL_PARALLEL_GLSL

#include "internal/tile.glsl"

// Defined by the shader. Gives a voxel near the start of a pixel's ray; false if it has no ray.
bool rx_tile_near(ivec2 pixel, out ivec3 cell);

// Defined by the shader. Gives the start of a pixel's ray, as in RxRay; false if it has no ray.
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
const int RX_PARALLEL_SPREAD = 96;            // voxels along each axis between rays that are traced together, at most; below 256
const float RX_PARALLEL_SLACK = 1.0 / 64.0;   // voxels: more than a place across the direction is off by rounding

#ifdef RX_LAYOUT_TREE64
// A cell near the centre of the rays.
shared ivec3 rx_parallel_anchor;
// The change of a place's pixel for a voxel along the direction.
shared vec4 rx_parallel_along;
shared int rx_parallel_values[12];
// Nodes on the way down, by the height of their children less 2, and their corners less RX_TILE_SLACK, relative to the origin.
shared uvec4 rx_tile_nodes[4];
shared vec4 rx_tile_places[4];
#endif

#ifdef RX_LAYOUT_TREE64
// The rays that this invocation traces: fractions; cells + 256 in 10 bits an axis, in mirrored axes.
vec4 rx_parallel_rays[8];

// The cell of a ray that this invocation traces, in mirrored axes.
vec3 rx_parallel_cell(uint s) {
    uint word = floatBitsToUint(rx_parallel_rays[s].w);
    return vec3(word & 1023u, (word >> 10) & 1023u, word >> 20) - 256.0;
}

// The least of each of twelve values over all invocations that have any. Not by a subgroup operation: a driver may
// let some invocations go ahead without the others, though all of them come here.
void rx_parallel_least(bool has, inout ivec3 a, inout ivec3 b, inout ivec3 c, inout ivec3 d) {
    barrier();
    if (gl_LocalInvocationIndex < 12u) rx_parallel_values[gl_LocalInvocationIndex] = 0x7fffffff;
    barrier();
    for (int i = 0; i < 3 && has; ++i) {
        atomicMin(rx_parallel_values[i], a[i]);
        atomicMin(rx_parallel_values[3 + i], b[i]);
        atomicMin(rx_parallel_values[6 + i], c[i]);
        atomicMin(rx_parallel_values[9 + i], d[i]);
    }
    barrier();
    a = ivec3(rx_parallel_values[0], rx_parallel_values[1], rx_parallel_values[2]);
    b = ivec3(rx_parallel_values[3], rx_parallel_values[4], rx_parallel_values[5]);
    c = ivec3(rx_parallel_values[6], rx_parallel_values[7], rx_parallel_values[8]);
    d = ivec3(rx_parallel_values[9], rx_parallel_values[10], rx_parallel_values[11]);
}

// The area of places, seen along a direction d. `sides` is their extent in x d.y - y d.x, y d.z - z d.y and z d.x - x d.z.
float rx_parallel_area(vec3 sides, vec3 d) {
    return (sides.x * sides.y + sides.y * sides.z + sides.z * sides.x) / dot(d, d);
}

// The region of all rays of a tile: bounds across the direction, and of their places.
void rx_parallel_measure(uint alive, vec3 d, out vec3 least, out vec3 most, out vec3 low, out vec3 high) {
    ivec3 cross_low = ivec3(0x7fffffff), cross_high = cross_low, low_at = cross_low, high_at = cross_low;
    for (uint s = 0u; s < 8u; ++s) {
        if (((alive >> s) & 1u) == 0u) continue;
        vec3 g = rx_parallel_rays[s].xyz, n = rx_parallel_cell(s), place = n + g;
        ivec3 across = ivec3(floor((place.xyz * d.yzx - place.yzx * d.xyz) * 256.0)), at = ivec3(n) * 256 + ivec3(g * 256.0);
        cross_low = min(cross_low, across);
        cross_high = min(cross_high, -1 - across);
        low_at = min(low_at, at);
        high_at = min(high_at, -1 - at);
    }
    rx_parallel_least(alive != 0u, cross_low, cross_high, low_at, high_at);
    least = vec3(cross_low) * (1.0 / 256.0) - RX_PARALLEL_SLACK;
    most = -vec3(cross_high) * (1.0 / 256.0) + RX_PARALLEL_SLACK;
    low = vec3(low_at) * (1.0 / 256.0);
    high = -vec3(high_at) * (1.0 / 256.0);
}
#endif

// `view` of rx_trace_parallel for rays that begin where those of a camera hit; view_cell and view_frac are the camera's.
void rx_camera_view(mat4 view_to_world, vec2 tan_half_fov, ivec2 size, out vec4 view[3]) {
    vec2 per_voxel = 0.5 * vec2(size) / tan_half_fov, middle = 0.5 * vec2(size - 1);
    vec3 right = view_to_world[0].xyz, up = view_to_world[1].xyz, ahead = -view_to_world[2].xyz;
    view[0] = vec4(right * per_voxel.x + middle.x * ahead, 0.0);
    view[1] = vec4(-up * per_voxel.y + middle.y * ahead, 0.0);
    view[2] = vec4(ahead, 0.0);
}

// `view`: from a place relative to view_cell and view_frac, (x, y, z, 1), three dot products give (u w, v w, w), with w at least 1 where
// rays begin: the ray of pixel (u, v) begins there, whole numbers are the centres of pixels. rx_camera_view computes `view` for a camera. A ray
// that begins more than 1/128 pixel from there is handed on.
uint rx_trace_parallel(ivec2 tile, ivec2 size, vec3 dir, ivec3 view_cell, vec3 view_frac, vec4 view[3]) {
    const uint lane = gl_LocalInvocationIndex;
    const ivec2 first = tile * RX_TILE;
    const ivec2 in_group = ivec2(lane & 7u, lane >> 3);

#ifdef RX_LAYOUT_TREE64
    const uvec3 lattice = rx_tile_lattice(dir);
    const bool down_x = dir.x < 0.0 && lattice.x != 0u, down_y = dir.y < 0.0 && lattice.y != 0u, down_z = dir.z < 0.0 && lattice.z != 0u;
    const vec3 sign_of = vec3(down_x ? -1.0 : 1.0, down_y ? -1.0 : 1.0, down_z ? -1.0 : 1.0);
    const vec3 d = vec3(lattice) * 9.31322574615478515625e-10;  // exactly
    {
        ivec3 cell = ivec3(0);
        ivec2 pixel = first + ivec2(5u * (lane & 3u), 2u * (lane >> 2) + (lane & 1u));
        bool near = all(lessThan(pixel, size)) && rx_tile_near(pixel, cell);
        vec3 place = vec3(cell - world.origin) * sign_of;
        ivec3 across = ivec3(floor(place.xyz * d.yzx - place.yzx * d.xyz)), least = across, most = -across, none = ivec3(0), nothing = ivec3(0);
        rx_parallel_least(near, least, most, none, nothing);
        if (least.x != 0x7fffffff && (lattice.x | lattice.y | lattice.z) != 0u && rx_parallel_area(vec3(-most - least) + 1.0, d) > RX_PARALLEL_NEAR) {
            uint all_pixels = 0u;
            for (uint s = 0u; s < 8u; ++s) all_pixels |= all(lessThan(rx_tile_pixel(tile, s), size)) ? 1u << s : 0u;
            return all_pixels;
        }
    }
#endif

    ivec3 cells[8];
    vec3 fracs[8];
    uint pending = 0u;  // bit s: this invocation's pixel of group s has a ray that is not traced
    for (uint s = 0u; s < 8u; ++s) {
        ivec2 pixel = rx_tile_pixel(tile, s);
        if (all(lessThan(pixel, size)) && rx_tile_start(pixel, cells[s], fracs[s])) pending |= 1u << s;
    }
    // Bit s: it is handed on, hits nothing.
    uint rest = 0u, missed = 0u;

#ifdef RX_LAYOUT_TREE64
    const uint last = (1u << world.log2_size) - 1u;
    const vec3 inv = 1.0 / max(d, vec3(1.0e-10));
    bool proven = RX_TILE_IN_STEP && (1 << world.log2_size) <= RX_TILE_REACH && !rx_not_finite(dir) && (lattice.x | lattice.y | lattice.z) != 0u;

    uint some = RX_TILE_BALLOT(pending != 0u);
    if (proven && some != 0u) {
        if (lane == uint(findLSB(some))) rx_parallel_anchor = cells[findLSB(pending)];
        barrier();
        // Places are in voxels from the anchor's corner, in mirrored axes.
        const ivec3 anchor = rx_parallel_anchor, from = anchor - world.origin;
        if (rx_beyond(from, RX_TILE_REACH) || rx_wraps(anchor, world.origin)) return pending;
        if (lane < 3u) {
            vec4 row = lane == 0u ? (view[0] - float(first.x) * view[2]) * 0.0625 : lane == 1u ? (view[1] - float(first.y) * view[2]) * 0.0625 : view[2];
            vec3 away = vec3(anchor - view_cell) + vec3(down_x ? 1.0 : 0.0, down_y ? 1.0 : 0.0, down_z ? 1.0 : 0.0) - view_frac;
            float at_zero = dot(row.xyz, away) + row.w;
            vec3 turned = row.xyz * sign_of;
            rx_tile_project[lane] = vec4(turned, at_zero + 0.5 * (turned.x + turned.y + turned.z));
            rx_tile_project[3][lane] = 0.5 * (abs(turned.x) + abs(turned.y) + abs(turned.z));
            rx_parallel_along[lane] = dot(turned, d);
        }
        barrier();  // before any invocation reads what three of them have written

        uint alive = 0u;  // bit s: the ray of this invocation's pixel of group s is traced and has not hit anything yet
        for (uint s = 0u; s < 8u; ++s) {
            ivec3 n = (cells[s] - anchor) * ivec3(sign_of);
            if (((pending >> s) & 1u) == 0u || any(greaterThan(uvec3(n + RX_PARALLEL_SPREAD), uvec3(2 * RX_PARALLEL_SPREAD)))) continue;
            if (rx_wraps(cells[s], anchor)) continue;
            vec3 g = floor(fracs[s] * 16777216.0) * 5.9604644775390625e-8;
            g = vec3(down_x ? 1.0 - g.x : g.x, down_y ? 1.0 - g.y : g.y, down_z ? 1.0 - g.z : g.z);
            vec3 middle = vec3(n) + (g - 0.5);
            float x = dot(rx_tile_project[0], vec4(middle, 1.0)), y = dot(rx_tile_project[1], vec4(middle, 1.0)), w = dot(rx_tile_project[2], vec4(middle, 1.0));
            ivec2 pixel = ivec2(8u * (s & 1u), 4u * (s >> 1)) + in_group;
            // By the least w in a voxel around the ray's origin, which is 1 or more, see `cover`: it decides the voxel's pixels.
            float near = max(w - 2.5 * rx_tile_project[3].z, 1.0) * (0.5 * RX_TILE_MARGIN);
            bool there = w >= 1.0 && abs(16.0 * x - float(pixel.x) * w) <= near && abs(16.0 * y - float(pixel.y) * w) <= near;
            // The walk traces a ray that begins outside of its cell: it counts as on the border, and the pixel is elsewhere.
            bool within = all(greaterThanEqual(g, vec3(0.0))) && all(lessThanEqual(g, vec3(1.0)));
            // At the centre of the cell on an axis that the ray does not move along, as in walk.glsl.
            g = mix(g, vec3(0.5), equal(lattice, uvec3(0u)));
            // A ray that begins on its exit plane spends no time in its cell. The walk traces it.
            bool simple = there && within && all(lessThan(g, vec3(1.0)));
            pending &= ~(1u << s);
            if (!simple) {
                rest |= 1u << s;
                continue;
            }
            alive |= 1u << s;
            rx_parallel_rays[s] = vec4(g, uintBitsToFloat(uint(n.x + 256) | (uint(n.y + 256) << 10) | (uint(n.z + 256) << 20)));
        }
        if (!RX_TILE_ANY(alive != 0u)) return rest | pending;
        vec3 least, most, low, high;
        rx_parallel_measure(alive, d, least, most, low, high);
        if (rx_parallel_area(most - least, d) > RX_PARALLEL_AREA) return rest | pending | alive;

        // Child l and child l + 32 of a node, voxel l and voxel l + 32 of a leaf are this invocation's.
        const uvec3 child = uvec3(lane & 3u, lane >> 4, (lane >> 2) & 3u);
        const vec3 child_at = vec3(child);
        const uint child_bit = 1u << (lane ^ ((down_x ? 3u : 0u) | (down_z ? 12u : 0u) | (down_y ? 16u : 0u)));
        const uint below = (1u << lane) - 1u, child_code = child.x | (child.y << 8) | (child.z << 16);

        uint looked_at = 0u, waiting = 0u;  // `waiting`: bit h: a node with children of height h has some that wait
        uint wait_1 = 0u, wait_2 = 0u;      // of invocation h: which
        bool too_much = false;
        uint height = (world.log2_size >> 1) - 1u, id = world.root;
        vec3 place = -vec3(down_x ? int(last) - from.x : from.x, down_y ? int(last) - from.y : from.y, down_z ? int(last) - from.z : from.z);
        for (;;) {
            // Visit a node, whose corner is at `place`.
            uvec4 node = uvec4(0xffffffffu, 0xffffffffu, 0u, RX_FILLED);
            if ((id & RX_TILE_FULL) == 0u) node = world.quads[id];
            uint mask_1 = down_y ? node.y : node.x, mask_2 = down_y ? node.x : node.y;
            bool visit_1, visit_2;
            {
                float side = uintBitsToFloat((height << 24) + 0x3f800000u);  // 4^height
                vec3 at = fma(child_at, vec3(side), place), across = at.xyz * d.yzx - at.yzx * d.xyz;
                vec3 to = fma(vec3(side), d, most), back = fma(vec3(-side), d.yzx, least);
                visit_1 = all(lessThanEqual(across, to)) && all(greaterThanEqual(across, back)) && all(greaterThan(at + side, low)) && (mask_1 & child_bit) != 0u;
                across += vec3(-2.0 * side * d.x, 2.0 * side * d.z, 0.0);
                at.y += 2.0 * side;
                visit_2 = all(lessThanEqual(across, to)) && all(greaterThanEqual(across, back)) && all(greaterThan(at + side, low)) && (mask_2 & child_bit) != 0u;
            }
            uint ones = RX_TILE_BALLOT(visit_1), twos = RX_TILE_BALLOT(visit_2);
            if ((ones | twos) != 0u && height > 1u) {
                if (lane == height) {
                    wait_1 = ones;
                    wait_2 = twos;
                }
                waiting |= 1u << height;
                barrier();
                if (lane == 0u) {
                    rx_tile_nodes[(height - 2u) & 3u] = node;
                    rx_tile_places[(height - 2u) & 3u] = vec4(place, 0.0);
                }
                barrier();
            } else if ((ones | twos) != 0u) {
                looked_at += uint(bitCount(ones)) + uint(bitCount(twos));
                if (looked_at > RX_PARALLEL_LEAVES) {
                    too_much = true;
                    break;
                }
                // Masks of the leaves. If no ray begins in a leaf, skip its voxels that no ray can hit first.
                uvec2 leaf_1 = uvec2(0xffffffffu), leaf_2 = uvec2(0xffffffffu);
                if ((node.w & RX_FILLED) == 0u) {
                    uint half_count = uint(bitCount(node.x));
                    if (visit_1) leaf_1 = rx_leaf(node.z + (down_y ? half_count : 0u) + uint(bitCount(mask_1 & (child_bit - 1u))));
                    if (visit_2) leaf_2 = rx_leaf(node.z + (down_y ? 0u : half_count) + uint(bitCount(mask_2 & (child_bit - 1u))));
                }
                vec3 leaf_at = fma(child_at, vec3(4.0), place);
                leaf_1 = any(greaterThan(leaf_at, high)) ? rx_tile_bare(leaf_1, down_x, down_y, down_z) : down_y ? leaf_1.yx : leaf_1;
                leaf_at.y += 8.0;
                leaf_2 = any(greaterThan(leaf_at, high)) ? rx_tile_bare(leaf_2, down_x, down_y, down_z) : down_y ? leaf_2.yx : leaf_2;

                uint candidates = 0u, taken = 0u;
                for (;;) {
                    bool more = (ones | twos) != 0u;
                    if (candidates - taken >= (more ? 32u : 1u)) {
                        barrier();
                        bool some_left = true;
                        for (; candidates - taken >= (more ? 32u : 1u) && some_left; taken = min(taken + 32u, candidates)) {
                            // Candidate l is this invocation's, and bit 31 - l of a set, so that the first is the highest bit.
                            {
                                uint code = rx_tile_candidates[(taken + lane) & 127u];
                                vec3 v = vec3(code & 255u, (code >> 8) & 255u, code >> 16) + place;
                                // When rays that it can stop begin: from `soon` to `late` before it.
                                vec3 nearest = (v - high) * inv, farthest = (v + 1.0 - low) * inv;
                                float soon = clamp(max(nearest.x, max(nearest.y, nearest.z)), 0.0, 1.0e5);
                                float late = clamp(min(farthest.x, min(farthest.y, farthest.z)), soon, 1.0e5);
                                vec4 row_x = rx_tile_project[0], row_y = rx_tile_project[1], row_z = rx_tile_project[2];
                                // Wider by the rounding errors of these times and places.
                                vec3 half_of = rx_tile_project[3].xyz * (1.0 + (late + 1024.0) * (2.0 * RX_TILE_ERROR)), along = rx_parallel_along.xyz;
                                vec3 at = vec3(fma(row_x.x, v.x, fma(row_x.y, v.y, fma(row_x.z, v.z, row_x.w))), fma(row_y.x, v.x, fma(row_y.y, v.y, fma(row_y.z, v.z, row_y.w))),
                                               fma(row_z.x, v.x, fma(row_z.y, v.y, fma(row_z.z, v.z, row_z.w))));
                                vec3 a = at - soon * along, b = at - late * along;
                                float near_a = 1.0 / (a.z - half_of.z), far_a = 1.0 / (a.z + half_of.z), near_b = 1.0 / (b.z - half_of.z), far_b = 1.0 / (b.z + half_of.z);
                                const float up = (0.5 + RX_TILE_MARGIN) * 0.0625, down = (0.5 - RX_TILE_MARGIN) * 0.0625;
                                float x_1 = clamp(max((a.x + half_of.x) * near_a, (b.x + half_of.x) * near_b) + up, 0.0, 1.0);
                                float x_0 = min(clamp(min((a.x - half_of.x) * far_a, (b.x - half_of.x) * far_b) + down, 0.0, 1.0), x_1);
                                float y_1 = clamp(max((a.y + half_of.y) * near_a, (b.y + half_of.y) * near_b) + up, 0.0, 1.0);
                                float y_0 = min(clamp(min((a.y - half_of.y) * far_a, (b.y - half_of.y) * far_b) + down, 0.0, 1.0), y_1);
                                uint columns = (1u << rx_tile_sixteenths(x_1)) - (1u << rx_tile_sixteenths(x_0));
                                uint rows = (1u << rx_tile_sixteenths(y_1)) - (1u << rx_tile_sixteenths(y_0));
                                uint cover = columns | (rows << 16);
                                if (!(min(a.z, b.z) - half_of.z >= 1.0)) cover = 0xffffffffu;  // beside the camera
                                rx_tile_sets(lane, taken + lane < candidates ? cover : 0u);
                                rx_tile_corners[31u - lane] = vec4(v, 0.0);
                            }
                            barrier();  // before any invocation reads the sets of all
                            // The pixels of this invocation that have candidates.
                            uint some_have = 0u;
                            for (uint i = 0u; i < 4u; ++i) {
                                uint row = rx_tile_lists[(16u | (lane >> 3) | (i << 2)) & 31u];
                                if ((rx_tile_lists[lane & 7u] & row) != 0u) some_have |= 1u << (2u * i);
                                if ((rx_tile_lists[8u | (lane & 7u)] & row) != 0u) some_have |= 2u << (2u * i);
                            }
                            some_have &= alive;
                            uint s = 0u, mine = 0u;  // the pixel of the moment, and which candidates it has left
                            while (RX_TILE_ANY((some_have | mine) != 0u)) {
                                bool fresh = mine == 0u, has = (some_have | mine) != 0u;
                                s = fresh ? uint(findLSB(some_have)) & 7u : s;
                                uint set = rx_tile_lists[8u * (s & 1u) + (lane & 7u)] & rx_tile_lists[16u + 4u * (s >> 1) + (lane >> 3)];
                                mine = fresh && has ? set : mine;
                                some_have &= ~(1u << s);
                                uint c = uint(findMSB(mine)) & 31u;
                                vec3 g = rx_parallel_rays[s].xyz, n = rx_tile_corners[c].xyz - rx_parallel_cell(s), v = n - g;
                                vec3 t_in = v * inv, t_out = (v + 1.0) * inv;
                                float enters = max(t_in.x, max(t_in.y, t_in.z)), leaves = min(t_out.x, min(t_out.y, t_out.z));
                                float inside = leaves - enters, bound = leaves * RX_TILE_ERROR;
                                bool ahead = min(n.x, min(n.y, n.z)) >= 0.0, own = max(n.x, max(n.y, n.z)) == 0.0, near = inside >= -bound, certain = inside > bound;
                                bool found = has && ahead && near, hit = found && certain;
#ifndef RX_TILE_ANY_HIT
                                float limit = enters - abs(enters) * RX_TILE_ERROR;
                                bool x = t_in.x >= limit, y = t_in.y >= limit, z = t_in.z >= limit, one = (x ? 1u : 0u) + (y ? 1u : 0u) + (z ? 1u : 0u) == 1u;
                                uint axis = x ? 0u : y ? 1u : 2u;
                                hit = hit && one;
#else
                                uint axis = 3u;
#endif
                                if (found && !hit && !own) {
                                    // Integers decide, seldom.
                                    axis = rx_tile_settle(uvec3(n), uvec3(g * 16777216.0), lattice);
                                    hit = axis < 3u;
#ifdef RX_TILE_ANY_HIT
                                    axis = 3u;
#endif
                                }
                                mine = has ? mine & ~(1u << c) : 0u;
                                if (found && (hit || own)) {
                                    mine = 0u;
                                    alive &= ~(1u << s);
                                    ivec3 at = ivec3(rx_tile_corners[c].xyz);
                                    ivec3 voxel = anchor + ivec3(down_x ? -at.x : at.x, down_y ? -at.y : at.y, down_z ? -at.z : at.z);
                                    uint face = 2u * axis + (axis < 3u && (axis == 0u ? down_x : axis == 1u ? down_y : down_z) ? 1u : 0u);
                                    if (own) rest |= 1u << s;
                                    else rx_tile_hit(rx_tile_pixel(tile, s), voxel, face);
                                }
                            }
                            some_left = RX_TILE_ANY(alive != 0u);
                        }
                        if (!some_left) break;
                    }
                    if (!more) break;
                    // A leaf: 4 x 4 x 4 voxels.
                    bool first_half = ones != 0u;
                    uint l = uint(findLSB(first_half ? ones : twos));
                    if (first_half) ones &= ones - 1u;
                    else twos &= twos - 1u;
                    uvec2 mask = first_half ? leaf_1 : leaf_2;
                    mask = uvec2(RX_TILE_READ(mask.x, l), RX_TILE_READ(mask.y, l));
                    uvec3 leaf = uvec3(l & 3u, (l >> 4) + (first_half ? 0u : 2u), (l >> 2) & 3u);
                    vec3 at = fma(vec3(leaf), vec3(4.0), place) + child_at, across = at.xyz * d.yzx - at.yzx * d.xyz;
                    vec3 to = most + d, back = least - d.yzx;
                    bool touch_1 = all(lessThanEqual(across, to)) && all(greaterThanEqual(across, back)) && all(greaterThan(at + 1.0, low)) && (mask.x & child_bit) != 0u;
                    across += vec3(-2.0 * d.x, 2.0 * d.z, 0.0);
                    at.y += 2.0;
                    bool touch_2 = all(lessThanEqual(across, to)) && all(greaterThanEqual(across, back)) && all(greaterThan(at + 1.0, low)) && (mask.y & child_bit) != 0u;
                    uint some_1 = RX_TILE_BALLOT(touch_1), some_2 = RX_TILE_BALLOT(touch_2);
                    if ((some_1 | some_2) != 0u) {
                        uint code = child_code + 4u * (leaf.x | (leaf.y << 8) | (leaf.z << 16));
                        if (touch_1) rx_tile_candidates[(candidates + uint(bitCount(some_1 & below))) & 127u] = code;
                        candidates += uint(bitCount(some_1));
                        if (touch_2) rx_tile_candidates[(candidates + uint(bitCount(some_2 & below))) & 127u] = code + 512u;
                        candidates += uint(bitCount(some_2));
                    }
                }
                if (!RX_TILE_ANY(alive != 0u)) break;
            }

            // The next node: a child that waits, of the lowest node that has one.
            if (waiting == 0u) break;
            height = uint(findLSB(waiting));
            uint left_1 = RX_TILE_READ(wait_1, height), left_2 = RX_TILE_READ(wait_2, height);
            bool first_half = left_1 != 0u;
            uint l = uint(findLSB(first_half ? left_1 : left_2));
            if (first_half) left_1 &= left_1 - 1u;
            else left_2 &= left_2 - 1u;
            if (lane == height) {
                wait_1 = left_1;
                wait_2 = left_2;
            }
            if ((left_1 | left_2) == 0u) waiting &= waiting - 1u;
            node = rx_tile_nodes[(height - 2u) & 3u];
            uint occupied = first_half != down_y ? node.x : node.y;
            uint bit = 1u << (l ^ ((down_x ? 3u : 0u) | (down_z ? 12u : 0u) | (down_y ? 16u : 0u)));
            id = (node.w & RX_FILLED) != 0u ? RX_TILE_FULL : node.z + (first_half != down_y ? 0u : uint(bitCount(node.x))) + uint(bitCount(occupied & (bit - 1u)));
            float side = uintBitsToFloat((height << 24) + 0x3f800000u);
            place = fma(vec3(l & 3u, (l >> 4) + (first_half ? 0u : 2u), (l >> 2) & 3u), vec3(side), rx_tile_places[(height - 2u) & 3u].xyz);
            --height;
        }
        // The remaining rays hit nothing, or are handed on.
        if (too_much) rest |= alive;
        else missed = alive;
    }
#endif
    for (; missed != 0u; missed &= missed - 1u) rx_tile_miss(rx_tile_pixel(tile, uint(findLSB(missed))));
    return rest | pending;
}

#endif
