// Layout `bvh`: a tree of boxes (a bounding volume hierarchy), flattened depth first, whose leaves hold blocks of 4 x 4 x 4 voxels.
//
// A node is eight words: smallest corner of its box, link, largest voxel of its box, kind; boxes are in voxels from world.origin. The
// low two bits of the kind are the axis that was split, and then the first child follows, and the link is the word of the second; or
// 3 for a leaf, of kind >> 2 blocks from the link on. A block is six words: its smallest corner, a mask (two words; voxel
// x + 4z + 16y), and a link: with the top bit set, the material of all its voxels; otherwise the halfword where their materials
// begin, packed in the order of the mask.
//
// The traversal with a stack, near child first, is the classical one (Pharr, Jakob, Humphreys, "Physically Based Rendering", 3rd
// edition, 4.3.4). What makes it exact: a ray never turns, so of two voxels on it the one with the smaller mirrored coordinates is
// the earlier one, and "is this box behind the hit?" is a comparison of integers. Floating point only skips boxes that the ray
// misses by more than its error; blocks are walked by walk.glsl.
#ifndef RAXEL_BVH_GLSL
#define RAXEL_BVH_GLSL

#include "walk.glsl"

layout(std430) readonly buffer RxWorld {
    ivec3 origin;         // smallest corner of a cube around the world
    uint log2_size;       // the cube has 2^log2_size voxels a side
    ivec3 bounds_min;     // smallest and largest coordinates of solid voxels
    uint material_count;
    ivec3 bounds_last;
    uint materials_at;    // word of the first material
    uint nodes_at;        // word of the root node
    uint node_count;
    uint blocks_at;       // word of the first block
    uint block_count;
    uint words[];
} world;

#include "material.glsl"

const uint RX_BVH_LEAF = 3u;         // in place of an axis
const uint RX_BVH_NODE_WORDS = 8u;
const uint RX_BVH_BLOCK_WORDS = 6u;
const uint RX_BVH_DEPTH = 32u;       // more than any tree has: every split halves its blocks

// 1 + 2^-17: the two times that are compared are each within 2^-19 of the truth (a difference, a sum, a product, a reciprocal of
// 2.5 ulp, and the place in the first cell, itself within 2^-20).
const float RX_BVH_ROOM = 1.00000762939453125;

struct RxBvhNode {
    uvec3 low;
    uint link;
    uvec3 last;
    uint kind;
};

RxBvhNode rx_bvh_node(uint at) {
    return RxBvhNode(uvec3(world.words[at], world.words[at + 1u], world.words[at + 2u]), world.words[at + 3u],
                     uvec3(world.words[at + 4u], world.words[at + 5u], world.words[at + 6u]), world.words[at + 7u]);
}

uint rx_block_voxel(uvec3 c) {
    return c.x | (c.z << 2) | (c.y << 4);
}

bool rx_block_solid(uvec2 mask, uint voxel) {
    return (((voxel >= 32u ? mask.y : mask.x) >> (voxel & 31u)) & 1u) != 0u;
}

// Material of a solid voxel of the block at word `at`.
uint rx_block_material(uint at, uint voxel) {
    uint link = world.words[at + 5u];
    if ((link & 0x80000000u) != 0u) return link & 0xffffu;
    uvec2 mask = uvec2(world.words[at + 3u], world.words[at + 4u]);
    uint below = (1u << (voxel & 31u)) - 1u;
    uint rank = voxel >= 32u ? uint(bitCount(mask.x) + bitCount(mask.y & below)) : uint(bitCount(mask.x & below));
    uint half_word = link + rank;
    return (world.words[half_word >> 1] >> ((half_word & 1u) * 16u)) & 0xffffu;
}

uint rx_material(ivec3 cell) {
    uvec3 c = uvec3(cell) - uvec3(world.origin);
    if (((c.x | c.y | c.z) >> world.log2_size) != 0u) return 0u;
    uint stack[RX_BVH_DEPTH];
    uint depth = 0u;
    uint at = world.nodes_at;
    for (uint visits = 0u; visits < world.node_count; ++visits) {
        RxBvhNode node = rx_bvh_node(at);
        bool inside = all(greaterThanEqual(c, node.low)) && all(lessThanEqual(c, node.last));
        if (inside && (node.kind & 3u) != RX_BVH_LEAF) {
            stack[depth++] = node.link;
            at += RX_BVH_NODE_WORDS;
            continue;
        }
        for (uint i = 0u; inside && i < node.kind >> 2; ++i) {
            uint block = node.link + RX_BVH_BLOCK_WORDS * i;
            if ((c & ~3u) != uvec3(world.words[block], world.words[block + 1u], world.words[block + 2u])) continue;
            uint voxel = rx_block_voxel(c & 3u);
            bool solid = rx_block_solid(uvec2(world.words[block + 3u], world.words[block + 4u]), voxel);
            return solid ? rx_block_material(block, voxel) : 0u;
        }
        if (depth == 0u) break;
        at = stack[--depth];
    }
    return 0u;
}

// Whether a ray may touch a box (mirrored: `near` to `far`) before t_end and at or before the cell `limit`. Never wrongly false.
bool rx_bvh_meets(RxWalk w, uvec3 near, uvec3 far, uvec3 limit, float t_end) {
    // A ray never moves down: boxes behind its first cell, or beyond the limit on any axis, are not met. The limit on an axis that
    // the ray does not move along is where it is.
    if (any(lessThan(far, w.entry)) || any(greaterThan(near, limit))) return false;
    uvec3 ahead = near - min(near, w.entry);  // planes to the one where the box begins; 0: it has begun
    vec3 enter = mix(vec3(max(ahead, uvec3(1u)) - 1u) * w.inv + w.first, vec3(0.0), equal(ahead, uvec3(0u)));
    vec3 leave = vec3(far - w.entry) * w.inv + w.first;
    float t = max(enter.x, max(enter.y, enter.z));
    return t <= min(leave.x, min(leave.y, leave.z)) * RX_BVH_ROOM && t <= t_end;
}

// The exact walk through the block at `corner`: the first solid voxel of the mask, as the place `q` in the mirrored block.
bool rx_block_trace(RxRay ray, float t_free, ivec3 corner, uvec2 mask, out uvec3 q, out uint axes, out uint voxel, inout uint steps) {
    RxWalk walk;
    q = uvec3(0u);
    axes = 0u;
    voxel = 0u;
    if (!rx_walk_begin(ray, corner, 2u, t_free, walk)) return false;
    // A line meets ten voxels of a block at most.
    for (uint i = 0u; i < 10u; ++i) {
        if (((walk.q.x | walk.q.y | walk.q.z) & ~3u) != 0u) return false;
        ++steps;
        voxel = rx_block_voxel(walk.q ^ rx_walk_flip(walk, 3u));
        if (rx_block_solid(mask, voxel)) {
            q = walk.q;
            axes = walk.axes;
            return true;
        }
        if (!rx_walk_step(walk, 0u)) rx_walk_settle(walk, ray, corner, 2u, 0u);
    }
    return false;
}

// The first solid voxel along a ray, not looked for before `t_free` (in lengths of the direction): until then it passes air only.
bool rx_trace_from(RxRay ray, float t_free, out RxHit hit) {
    hit = RxHit(ivec3(0), 0u, 0u, 0.0, vec2(0.0), 0u);
    RxWalk walk;
    if (!rx_walk_begin(ray, world.origin, world.log2_size, t_free, walk)) return false;
    float t_end = walk.t_end;
    bvec3 down = rx_walk_down(walk);
    uvec3 flip = rx_walk_flip(walk, (1u << world.log2_size) - 1u);
    // The earliest solid voxel so far.
    uvec3 limit = mix(uvec3((1u << world.log2_size) - 1u), walk.entry, equal(walk.d, vec3(0.0)));
    uint found = 0u, found_voxel = 0u, found_axes = 0u;

    uint stack[RX_BVH_DEPTH];
    uint depth = 0u;
    uint at = world.nodes_at;
    uint steps = 0u;
    for (uint visits = 0u; visits < world.node_count; ++visits) {
        RxBvhNode node = rx_bvh_node(at);
        ++steps;
        uvec3 near = mix(node.low, node.last ^ flip, down);
        uvec3 far = mix(node.last, node.low ^ flip, down);
        bool meets = rx_bvh_meets(walk, near, far, limit, t_end);
        uint axis = node.kind & 3u;
        if (meets && axis != RX_BVH_LEAF) {
            // The child that the ray comes to first.
            bool second = axis == 0u ? down.x : axis == 1u ? down.y : down.z;
            stack[depth++] = second ? at + RX_BVH_NODE_WORDS : node.link;
            at = second ? node.link : at + RX_BVH_NODE_WORDS;
            continue;
        }
        for (uint i = 0u; meets && i < node.kind >> 2; ++i) {
            uint block = node.link + RX_BVH_BLOCK_WORDS * i;
            uvec3 corner = uvec3(world.words[block], world.words[block + 1u], world.words[block + 2u]);
            near = mix(corner, (corner + 3u) ^ flip, down);
            if (!rx_bvh_meets(walk, near, near + 3u, limit, t_end)) continue;
            uvec2 mask = uvec2(world.words[block + 3u], world.words[block + 4u]);
            uvec3 q;
            uint axes, voxel;
            if (!rx_block_trace(ray, t_free, world.origin + ivec3(corner), mask, q, axes, voxel, steps)) continue;
            // The ray is in this block at or before the limit, and blocks share no voxel: this one is earlier.
            limit = near + q;
            found = block;
            found_voxel = voxel;
            found_axes = axes;
        }
        if (depth == 0u) break;
        at = stack[--depth];
    }

    hit.steps = steps;
    if (found == 0u) return false;
    walk.q = limit;
    walk.axes = found_axes;
    bool within = rx_walk_hit(walk, ray, world.origin, world.log2_size, hit);
    hit.material = rx_block_material(found, found_voxel);
    hit.steps = steps;
    return within;
}

bool rx_trace(RxRay ray, out RxHit hit) {
    return rx_trace_from(ray, 0.0, hit);
}

#endif
