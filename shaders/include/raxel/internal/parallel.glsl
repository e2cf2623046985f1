// The steps of rx_trace_parallel (parallel.glsl), in their order: the rays of a tile, the candidates, the leaves of a node, and the walk through the nodes.
// Steps that rays of a camera have as well are in tile.glsl.
#ifndef RAXEL_INTERNAL_PARALLEL_GLSL
#define RAXEL_INTERNAL_PARALLEL_GLSL

#include "tile.glsl"

const int RX_PARALLEL_SPREAD = 96;            // voxels along each axis between rays that are traced together, at most; below 256
const float RX_PARALLEL_SLACK = 1.0 / 64.0;   // voxels: more than a place across the direction is off by rounding

// A cell that is about in the middle of the rays.
shared ivec3 rx_parallel_anchor;
// What a voxel along the direction adds to a place's pixel.
shared vec4 rx_parallel_along;
shared int rx_parallel_values[12];
// Nodes on the way down, by the height of their children less 2: the node, and the place of its corner, relative to the anchor's.
shared uvec4 rx_parallel_nodes[4];
shared vec4 rx_parallel_places[4];

// The rays that this invocation traces: fractions; cells + 256 in 10 bits an axis, in mirrored axes.
vec4 rx_parallel_rays[8];

// The direction of all rays of a tile, without its signs.
struct RxParallel {
    uvec3 lattice;  // on the lattice
    vec3 d;         // the same, exactly
    vec3 inv;       // 1 / d
    ivec3 anchor;   // rx_parallel_anchor: places are in voxels from its corner, in mirrored axes
};

// What lies between all rays of a tile: bounds across the direction, and of their places.
struct RxParallelBounds {
    vec3 least, most;
    vec3 low, high;
};

// The walk of a tile through the tree.
struct RxParallelWalk {
    uint alive;           // bit s: the ray of this invocation's pixel of group s has not hit anything yet
    uint id;              // the node to visit, or RX_TILE_FULL
    uint height;          // of its children
    vec3 place;           // of its corner
    uint waiting;         // bit h: a node with children of height h has some that wait
    uint wait_1, wait_2;  // of invocation h: which, of the first half and of the second
    uint looked_at;       // leaves
    bool too_much;        // it has ended early, and what is alive is to be handed on
};

vec3 rx_parallel_cell(uint s) {
    uint word = floatBitsToUint(rx_parallel_rays[s].w);
    return vec3(word & 1023u, (word >> 10) & 1023u, word >> 20) - 256.0;
}

// The least of each of twelve values over all invocations that have any. Not by a subgroup operation: on an NVIDIA H200 some invocations went ahead without the
// others, though all of them come here.
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

// How far places are from the line along a direction through the origin, on three axes across it.
vec3 rx_parallel_across(vec3 place, vec3 d) {
    return place.xyz * d.yzx - place.yzx * d.xyz;
}

// How much room places take up, seen along a direction d: `sides` is how far apart they are in x d.y - y d.x, y d.z - z d.y and z d.x - x d.z.
float rx_parallel_area(vec3 sides, vec3 d) {
    return (sides.x * sides.y + sides.y * sides.z + sides.z * sides.x) / dot(d, d);
}

// Whether the rays of a tile are too far apart, by 32 of them.
bool rx_parallel_apart(ivec2 tile, ivec2 size, RxTileOctant octant, vec3 d) {
    const uint lane = gl_LocalInvocationIndex;
    ivec3 cell = ivec3(0);
    ivec2 pixel = tile * RX_TILE + ivec2(5u * (lane & 3u), 2u * (lane >> 2) + (lane & 1u));
    bool near = all(lessThan(pixel, size)) && rx_tile_near(pixel, cell);
    vec3 place = vec3(cell - world.origin) * rx_tile_signs(octant);
    ivec3 across = ivec3(floor(rx_parallel_across(place, d))), least = across, most = -across, none = ivec3(0), nothing = ivec3(0);
    rx_parallel_least(near, least, most, none, nothing);
    return least.x != 0x7fffffff && rx_parallel_area(vec3(-most - least) + 1.0, d) > RX_PARALLEL_NEAR;
}

// Writes rx_tile_project and rx_parallel_along. A barrier has to follow.
void rx_parallel_frame(ivec2 tile, RxTileOctant octant, RxParallel rays, ivec3 view_cell, vec3 view_frac, vec4 view[3]) {
    const uint lane = gl_LocalInvocationIndex;
    const ivec2 first = tile * RX_TILE;
    if (lane < 3u) {
        vec4 row = lane == 0u ? (view[0] - float(first.x) * view[2]) * 0.0625 : lane == 1u ? (view[1] - float(first.y) * view[2]) * 0.0625 : view[2];
        vec3 away = vec3(rays.anchor - view_cell) + rx_tile_fraction(octant, vec3(0.0)) - view_frac;
        float at_zero = dot(row.xyz, away) + row.w;
        vec3 turned = row.xyz * rx_tile_signs(octant);
        rx_tile_project[lane] = vec4(turned, at_zero + 0.5 * (turned.x + turned.y + turned.z));
        rx_tile_project[3][lane] = 0.5 * (abs(turned.x) + abs(turned.y) + abs(turned.z));
        rx_parallel_along[lane] = dot(turned, rays.d);
    }
}

// Takes a ray into the tile, as that of group s. False if it is far from the others, or does not begin where rx_tile_project says: it is handed on.
bool rx_parallel_take(RxTileOctant octant, RxParallel rays, uint s, ivec3 cell, vec3 frac) {
    ivec3 n = (cell - rays.anchor) * ivec3(rx_tile_signs(octant));
    if (any(greaterThan(uvec3(n + RX_PARALLEL_SPREAD), uvec3(2 * RX_PARALLEL_SPREAD))) || rx_wraps(cell, rays.anchor)) return false;
    vec3 g = rx_tile_fraction(octant, floor(frac * 16777216.0) * 5.9604644775390625e-8);
    vec4 middle = vec4(vec3(n) + (g - 0.5), 1.0);
    float x = dot(rx_tile_project[0], middle), y = dot(rx_tile_project[1], middle), w = dot(rx_tile_project[2], middle);
    ivec2 pixel = rx_tile_pixel(ivec2(0), s);
    bool there = w >= 1.0 && abs(16.0 * x - float(pixel.x) * w) <= w * (0.5 * RX_TILE_MARGIN) && abs(16.0 * y - float(pixel.y) * w) <= w * (0.5 * RX_TILE_MARGIN);
    // In the middle of the cell on an axis that the ray does not move along, as in walk.glsl.
    g = mix(g, vec3(0.5), equal(rays.lattice, uvec3(0u)));
    rx_parallel_rays[s] = vec4(g, uintBitsToFloat(uint(n.x + 256) | (uint(n.y + 256) << 10) | (uint(n.z + 256) << 20)));
    return there && all(greaterThanEqual(g, vec3(0.0))) && all(lessThan(g, vec3(1.0)));
}

// The bounds of the rays that are alive.
RxParallelBounds rx_parallel_measure(uint alive, vec3 d) {
    ivec3 cross_low = ivec3(0x7fffffff), cross_high = cross_low, low_at = cross_low, high_at = cross_low;
    for (uint s = 0u; s < 8u; ++s) {
        if (((alive >> s) & 1u) == 0u) continue;
        vec3 g = rx_parallel_rays[s].xyz, n = rx_parallel_cell(s);
        ivec3 across = ivec3(floor(rx_parallel_across(n + g, d) * 256.0)), at = ivec3(n) * 256 + ivec3(g * 256.0);
        cross_low = min(cross_low, across);
        cross_high = min(cross_high, -1 - across);
        low_at = min(low_at, at);
        high_at = min(high_at, -1 - at);
    }
    rx_parallel_least(alive != 0u, cross_low, cross_high, low_at, high_at);
    vec3 least = vec3(cross_low) * (1.0 / 256.0) - RX_PARALLEL_SLACK;
    vec3 most = -vec3(cross_high) * (1.0 / 256.0) + RX_PARALLEL_SLACK;
    return RxParallelBounds(least, most, vec3(low_at) * (1.0 / 256.0), -vec3(high_at) * (1.0 / 256.0));
}

// Whether rays can meet two cubes: one at a place with edges of `side` voxels, and one that is two edges further along y.
void rx_parallel_meets(RxParallelBounds bounds, vec3 d, vec3 at, float side, out bool first, out bool second) {
    vec3 across = rx_parallel_across(at, d), to = fma(vec3(side), d, bounds.most), back = fma(vec3(-side), d.yzx, bounds.least);
    first = all(lessThanEqual(across, to)) && all(greaterThanEqual(across, back)) && all(greaterThan(at + side, bounds.low));
    across += vec3(-2.0 * side * d.x, 2.0 * side * d.z, 0.0);
    at.y += 2.0 * side;
    second = all(lessThanEqual(across, to)) && all(greaterThanEqual(across, back)) && all(greaterThan(at + side, bounds.low));
}

// Candidate l of 32 is this invocation's: finds the columns and rows of pixels whose rays it can stop, and makes sets of candidates of them.
void rx_parallel_project(RxParallel rays, RxParallelBounds bounds, vec3 place, uint taken, uint candidates) {
    const uint lane = gl_LocalInvocationIndex;
    uint code = rx_tile_candidates[(taken + lane) & 127u];
    vec3 v = vec3(code & 255u, (code >> 8) & 255u, code >> 16) + place;
    // When rays that it can stop begin: from `soon` to `late` before it.
    vec3 nearest = (v - bounds.high) * rays.inv, farthest = (v + 1.0 - bounds.low) * rays.inv;
    float soon = clamp(max(nearest.x, max(nearest.y, nearest.z)), 0.0, 1.0e5);
    float late = clamp(min(farthest.x, min(farthest.y, farthest.z)), soon, 1.0e5);
    // Wider by what these times and places are off by rounding.
    vec3 half_of = rx_tile_project[3].xyz * (1.0 + (late + 1024.0) * (2.0 * RX_TILE_ERROR)), along = rx_parallel_along.xyz;
    vec3 at = rx_tile_view(v), a = at - soon * along, b = at - late * along;
    float near_a = 1.0 / (a.z - half_of.z), far_a = 1.0 / (a.z + half_of.z), near_b = 1.0 / (b.z - half_of.z), far_b = 1.0 / (b.z + half_of.z);
    const float up = (0.5 + RX_TILE_MARGIN) * 0.0625, down = (0.5 - RX_TILE_MARGIN) * 0.0625;
    vec2 most = max((a.xy + half_of.xy) * near_a, (b.xy + half_of.xy) * near_b) + up, least = min((a.xy - half_of.xy) * far_a, (b.xy - half_of.xy) * far_b) + down;
    uint cover = rx_tile_span(least.x, most.x) | (rx_tile_span(least.y, most.y) << 16);
    if (!(min(a.z, b.z) - half_of.z >= 1.0)) cover = 0xffffffffu;  // beside the camera
    rx_tile_sets(taken + lane < candidates ? cover : 0u);
    rx_tile_corners[31u - lane] = vec4(v, 0.0);
}

// Tests the pixels that have candidates, one candidate a round. Takes pixels that hit something out of `alive`.
void rx_parallel_test(ivec2 tile, RxTileOctant octant, RxParallel rays, inout uint alive, inout uint rest) {
    uint pending = rx_tile_groups() & alive;
    uint s = 0u, mine = 0u;  // the pixel of the moment, and which candidates it has left
    while (RX_TILE_ANY((pending | mine) != 0u)) {
        bool fresh = mine == 0u, has = (pending | mine) != 0u;
        s = fresh ? uint(findLSB(pending)) & 7u : s;
        uint set = rx_tile_lists[rx_tile_column(s) & 31u] & rx_tile_lists[rx_tile_row(s) & 31u];
        mine = fresh && has ? set : mine;
        pending &= ~(1u << s);
        uint c = uint(findMSB(mine)) & 31u;
        vec3 g = rx_parallel_rays[s].xyz, n = rx_tile_corners[c].xyz - rx_parallel_cell(s);
        RxTileTouch touch = rx_tile_touch(n - g, rays.inv, RX_TILE_ERROR);
        bool ahead = min(n.x, min(n.y, n.z)) >= 0.0, own = max(n.x, max(n.y, n.z)) == 0.0;
        bool found = has && ahead && touch.near, hit = found && touch.certain;
#ifndef RX_TILE_ANY_HIT
        uint axis = touch.axis;
        hit = hit && touch.one;
#else
        uint axis = 3u;
#endif
        if (found && !hit && !own) {
            // Integers tell, seldom.
            axis = rx_tile_settle(uvec3(n), uvec3(g * 16777216.0), rays.lattice);
            hit = axis < 3u;
#ifdef RX_TILE_ANY_HIT
            axis = 3u;
#endif
        }
        mine = has ? mine & ~(1u << c) : 0u;
        if (found && (hit || own)) {
            mine = 0u;
            alive &= ~(1u << s);
            if (own) rest |= 1u << s;
            else rx_tile_hit(rx_tile_pixel(tile, s), rays.anchor + rx_tile_turned(octant, ivec3(rx_tile_corners[c].xyz)), rx_tile_face(octant, axis));
        }
    }
}

// The mask of a leaf at a place, without voxels that no ray can hit first if no ray begins in it.
uvec2 rx_parallel_bare(RxTileOctant octant, RxParallelBounds bounds, uvec2 leaf, vec3 at) {
    return any(greaterThan(at, bounds.high)) ? rx_tile_bare(octant, leaf) : octant.down_y ? leaf.yx : leaf;
}

// A child of a node: of the first half if there are `ones`, else of the second. Takes it out of its half, and gives its place in the node.
uvec3 rx_parallel_next(inout uint ones, inout uint twos, out bool first_half, out uint l) {
    first_half = ones != 0u;
    l = uint(findLSB(first_half ? ones : twos));
    if (first_half) ones &= ones - 1u;
    else twos &= twos - 1u;
    return uvec3(l & 3u, (l >> 4) + (first_half ? 0u : 2u), (l >> 2) & 3u);
}

// Goes through the leaves of a node, until all are done or no pixel is left. `ones` and `twos` are those that are visited, leaf_1 and leaf_2 the masks
// of this invocation's.
void rx_parallel_leaves(ivec2 tile, RxTileOctant octant, RxParallel rays, RxParallelBounds bounds, uint ones, uint twos, uvec2 leaf_1, uvec2 leaf_2,
                        inout RxParallelWalk walk, inout uint rest) {
    uint candidates = 0u, taken = 0u;
    for (;;) {
        bool more = (ones | twos) != 0u;
        uint least = more ? 32u : 1u;
        if (candidates - taken >= least) {
            barrier();
            bool some_left = true;
            for (; candidates - taken >= least && some_left; taken = min(taken + 32u, candidates)) {
                rx_parallel_project(rays, bounds, walk.place, taken, candidates);
                barrier();
                rx_parallel_test(tile, octant, rays, walk.alive, rest);
                some_left = RX_TILE_ANY(walk.alive != 0u);
            }
            if (!some_left) break;
        }
        if (!more) break;
        // The voxels of the next leaf that rays can meet become candidates.
        bool first_half, touch_1, touch_2;
        uint l;
        uvec3 leaf = rx_parallel_next(ones, twos, first_half, l);
        uvec2 mask = first_half ? leaf_1 : leaf_2;
        mask = uvec2(RX_TILE_READ(mask.x, l), RX_TILE_READ(mask.y, l));
        rx_parallel_meets(bounds, rays.d, fma(vec3(leaf), vec3(4.0), walk.place) + octant.child_at, 1.0, touch_1, touch_2);
        touch_1 = touch_1 && (mask.x & octant.child_bit) != 0u;
        touch_2 = touch_2 && (mask.y & octant.child_bit) != 0u;
        uint some_1 = RX_TILE_BALLOT(touch_1), some_2 = RX_TILE_BALLOT(touch_2);
        if ((some_1 | some_2) != 0u) {
            uint code = octant.child_code + 4u * (leaf.x | (leaf.y << 8) | (leaf.z << 16));
            rx_tile_append(octant, touch_1, touch_2, some_1, some_2, code, candidates);
        }
    }
}

// Lets the children of a node wait.
void rx_parallel_push(uvec4 node, uint ones, uint twos, inout RxParallelWalk walk) {
    const uint lane = gl_LocalInvocationIndex;
    if (lane == walk.height) {
        walk.wait_1 = ones;
        walk.wait_2 = twos;
    }
    walk.waiting |= 1u << walk.height;
    barrier();
    if (lane == 0u) {
        rx_parallel_nodes[(walk.height - 2u) & 3u] = node;
        rx_parallel_places[(walk.height - 2u) & 3u] = vec4(walk.place, 0.0);
    }
    barrier();
}

// Goes on to a child that waits, of the lowest node that has one.
void rx_parallel_pop(RxTileOctant octant, inout RxParallelWalk walk) {
    walk.height = uint(findLSB(walk.waiting));
    uint left_1 = RX_TILE_READ(walk.wait_1, walk.height), left_2 = RX_TILE_READ(walk.wait_2, walk.height), l;
    bool first_half;
    uvec3 child = rx_parallel_next(left_1, left_2, first_half, l);
    if (gl_LocalInvocationIndex == walk.height) {
        walk.wait_1 = left_1;
        walk.wait_2 = left_2;
    }
    if ((left_1 | left_2) == 0u) walk.waiting &= walk.waiting - 1u;
    uvec4 node = rx_parallel_nodes[(walk.height - 2u) & 3u];
    bool low_half = first_half != octant.down_y;
    uint occupied = low_half ? node.x : node.y;
    uint bit = rx_tile_child_bit(l, octant.down_x, octant.down_y, octant.down_z);
    walk.id = (node.w & RX_FILLED) != 0u ? RX_TILE_FULL : node.z + (low_half ? 0u : uint(bitCount(node.x))) + uint(bitCount(occupied & (bit - 1u)));
    walk.place = fma(vec3(child), vec3(rx_tile_side(walk.height)), rx_parallel_places[(walk.height - 2u) & 3u].xyz);
    --walk.height;
}

// Walks through the tree until no node or no pixel is left, or it was too much.
RxParallelWalk rx_parallel_walk(ivec2 tile, RxTileOctant octant, RxParallel rays, RxParallelBounds bounds, uint alive, inout uint rest) {
    vec3 root = rx_tile_root(octant, rays.anchor - world.origin);
    RxParallelWalk walk = RxParallelWalk(alive, world.root, (world.log2_size >> 1) - 1u, root, 0u, 0u, 0u, 0u, false);
    for (;;) {
        uvec4 node = rx_tile_node((walk.id & RX_TILE_FULL) != 0u, walk.id);
        uint mask_1, mask_2;
        rx_tile_masks(octant, node, mask_1, mask_2);
        float side = rx_tile_side(walk.height);
        bool visit_1, visit_2;
        rx_parallel_meets(bounds, rays.d, fma(octant.child_at, vec3(side), walk.place), side, visit_1, visit_2);
        visit_1 = visit_1 && (mask_1 & octant.child_bit) != 0u;
        visit_2 = visit_2 && (mask_2 & octant.child_bit) != 0u;
        uint ones = RX_TILE_BALLOT(visit_1), twos = RX_TILE_BALLOT(visit_2);
        if ((ones | twos) != 0u && walk.height > 1u) {
            rx_parallel_push(node, ones, twos, walk);
        } else if ((ones | twos) != 0u) {
            walk.looked_at += uint(bitCount(ones)) + uint(bitCount(twos));
            walk.too_much = walk.looked_at > RX_PARALLEL_LEAVES;
            if (walk.too_much) break;
            uint child_1, child_2;
            uvec2 leaf_1, leaf_2;
            rx_tile_children(octant, node, child_1, child_2);
            rx_tile_leaves(node, visit_1, visit_2, child_1, child_2, leaf_1, leaf_2);
            vec3 leaf_at = fma(octant.child_at, vec3(4.0), walk.place);
            leaf_1 = rx_parallel_bare(octant, bounds, leaf_1, leaf_at);
            leaf_2 = rx_parallel_bare(octant, bounds, leaf_2, leaf_at + vec3(0.0, 8.0, 0.0));
            rx_parallel_leaves(tile, octant, rays, bounds, ones, twos, leaf_1, leaf_2, walk, rest);
            if (!RX_TILE_ANY(walk.alive != 0u)) break;
        }
        if (walk.waiting == 0u) break;
        rx_parallel_pop(octant, walk);
    }
    return walk;
}

#endif
