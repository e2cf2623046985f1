// Layout `bvh`: a tree of boxes (a bounding volume hierarchy), flattened depth first, whose leaves hold blocks of 4 x 4 x 4 voxels.
//
// A node is eight words: smallest corner of its box, link, largest voxel of its box, kind; boxes are in voxels from
// world.origin. The low two bits of the kind are the split axis: the first child follows the node, and the link is the word of
// the second. They are 3 for a leaf: it has kind >> 2 blocks from the link on. A block is six words: its smallest corner, a mask
// (two words; voxel x + 4z + 16y), and a link: with the top bit set, the material of all its voxels; otherwise the halfword
// where their materials begin, packed in the order of the mask.
//
// The traversal with a stack, near child first, is the classical one (Pharr, Jakob, Humphreys, "Physically Based Rendering", 3rd edition,
// 4.3.4). It is exact because a ray never turns. Of two voxels on a ray, the earlier one has the smaller mirrored
// coordinates, so integers decide "is this box behind the hit?". Floating point only skips boxes that the ray misses by more
// than its error; blocks are walked by walk.glsl.
#include <raxel/internal/walk.glsl>

#ifdef RX_WRITE
#error "the layout `bvh` has no rx_set: its blocks are packed, without room for one more; use chunks, chunk_table, octree or texture3d"
#endif

layout(std430) readonly buffer RxWorld {
#include <raxel/internal/header.glsl>
    uint nodes_at;        // word of the root node
    uint node_count;
    uint blocks_at;       // word of the first block
    uint block_count;
    uint words[];
} world;

#include <raxel/internal/material.glsl>

const uint RX_BVH_LEAF = 3u;         // in place of an axis
const uint RX_BVH_NONE = 0xffffffffu;  // in place of a node
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

// Takes a walk from its frame to the first cell of the block at `near` (mirrored), which the ray may touch. If floating
// point cannot decide the cell, returns false and does nothing. That happens if an axis is crossed nearly as late as the
// last one: the ray is then nearly between two cells.
bool rx_bvh_enter(inout RxWalk w, uvec3 near) {
    bvec3 ahead = greaterThan(near, w.entry);
    precise vec3 times = mix(vec3(-1.0), vec3(near - 1u - w.entry) * w.inv + w.first, ahead);
    float t = max(times.x, max(times.y, times.z));
    if (t < 0.0) return true;  // begins in it
    return rx_walk_to(w, times, t, near);
}

// The same, decided by integers. A ray that is never in the block is left before it.
void rx_bvh_enter_exactly(inout RxWalk w, RxRay ray, float t_free, ivec3 corner, uvec3 near) {
    RxWalk exact;
    w.q = near + 4u;
    if (!rx_walk_begin(ray, corner, 2u, t_free, exact)) return;
    w.q = near + exact.q;
    w.axes = exact.axes;
    w.t = exact.base + exact.t - w.base;
}

// Walks through the block at word `block`, whose mirrored corner is `near`, up to its first solid voxel. True if it has one on the walk. `sure` is false if
// floating point cannot decide a step; the walk stands before it then.
bool rx_bvh_cross(inout RxWalk w, uint block, uvec3 near, uvec3 flip, inout uint steps, out bool sure) {
    uvec2 mask = uvec2(world.words[block + 3u], world.words[block + 4u]);
    bool solid = false;
    sure = true;
    while (sure && !solid && (((w.q.x ^ near.x) | (w.q.y ^ near.y) | (w.q.z ^ near.z)) & ~3u) == 0u) {
        ++steps;
        solid = rx_block_solid(mask, rx_block_voxel((w.q ^ flip) & 3u));
        if (!solid) sure = rx_walk_step(w, 0u);
    }
    return solid;
}

// The first solid voxel along a ray, not looked for before `t_free` (in lengths of the direction): until then it passes air only.
//
// Rounds of the outer loop do the rare work; each round of the next searches the tree for a block, and walks through it. A group
// of threads takes as long as its slowest thread, so all search together and walk together (Aila, Laine, "Understanding the
// efficiency of ray traversal on GPUs", 2009).
bool rx_trace_from(RxRay ray, float t_free, out RxHit hit) {
    hit = RxHit(ivec3(0), 0u, 0u, 0.0, vec2(0.0), 0u);
    RxWalk start;
    if (!rx_walk_begin(ray, world.origin, world.log2_size, t_free, start)) return false;
    uint last_cell = (1u << world.log2_size) - 1u;
    bvec3 down = rx_walk_down(start);
    uvec3 flip = rx_walk_flip(start, last_cell);
    // The earliest solid voxel so far.
    uvec3 limit = mix(uvec3(last_cell), start.entry, equal(start.d, vec3(0.0)));
    uint found = 0u, found_axes = 0u;

    uint stack[RX_BVH_DEPTH];
    uint depth = 0u;
    uint node = world.nodes_at;
    uint next = 0u, left = 0u;  // blocks of a leaf that are still to be tested
    uint block = 0u;            // the one that is walked through
    uvec3 near = uvec3(0u);
    RxWalk walk = start;
    uint steps = 0u;
    uint budget = world.node_count + world.block_count;  // each is tested at most once
    const uint SEARCH = 0u, ENTER = 1u, STEP = 2u, DONE = 3u;
    uint todo = SEARCH;
    do {
        if (todo == ENTER) {
            uvec3 corner = uvec3(world.words[block], world.words[block + 1u], world.words[block + 2u]);
            rx_bvh_enter_exactly(walk, ray, t_free, world.origin + ivec3(corner), near);
        } else if (todo == STEP) {
            rx_walk_settle(walk, ray, world.origin, world.log2_size, 0u);
        }
        bool walking = todo != SEARCH;
        todo = SEARCH;
        while (todo == SEARCH) {
            // To the next block that the ray may touch, unless it is in one.
            bool meets = walking;
            while (!meets && (left != 0u || node != RX_BVH_NONE) && budget != 0u) {
                bool in_leaf = left != 0u;
                uint at = in_leaf ? next : node;
                uvec3 low = uvec3(world.words[at], world.words[at + 1u], world.words[at + 2u]);
                uint link = world.words[at + 3u];
                uvec3 last = in_leaf ? low + 3u : uvec3(world.words[at + 4u], world.words[at + 5u], world.words[at + 6u]);
                uint kind = in_leaf ? 0u : world.words[at + 7u];
                near = mix(low, last ^ flip, down);
                meets = rx_bvh_meets(start, near, mix(last, low ^ flip, down), limit, start.t_end);
                ++steps;
                --budget;
                if (in_leaf) {
                    block = next;
                    next += RX_BVH_BLOCK_WORDS;
                    --left;
                    continue;
                }
                uint axis = kind & 3u;
                if (meets && axis != RX_BVH_LEAF) {
                    // The child that the ray comes to first.
                    bool second = axis == 0u ? down.x : axis == 1u ? down.y : down.z;
                    stack[depth++] = second ? at + RX_BVH_NODE_WORDS : link;
                    node = second ? link : at + RX_BVH_NODE_WORDS;
                } else {
                    left = meets ? kind >> 2 : 0u;
                    next = link;
                    node = depth != 0u ? stack[--depth] : RX_BVH_NONE;
                }
                meets = false;
            }
            if (!meets) {
                todo = DONE;
                break;
            }
            if (!walking) {
                walk = start;
                if (!rx_bvh_enter(walk, near)) {
                    todo = ENTER;
                    break;
                }
            }
            walking = false;
            bool sure;
            if (rx_bvh_cross(walk, block, near, flip, steps, sure)) {
                // The ray is in this block at or before the limit, and blocks share no voxel: this one is earlier.
                limit = walk.q;
                found = block;
                found_axes = walk.axes;
            }
            if (!sure) todo = STEP;
        }
    } while (todo != DONE);

    hit.steps = steps;
    if (found == 0u) return false;
    start.q = limit;
    start.axes = found_axes;
    bool within = rx_walk_hit(start, ray, world.origin, world.log2_size, hit);
    hit.material = rx_block_material(found, rx_block_voxel((limit ^ flip) & 3u));
    hit.steps = steps;
    return within;
}

bool rx_trace(RxRay ray, out RxHit hit) {
    return rx_trace_from(ray, 0.0, hit);
}
