// Layout `tree64`: a sparse tree whose nodes each split their cube into 4 x 4 x 4 children.
//
// A node of 16^3 voxels or more is four words, read at once: a mask of its occupied children (two words; child x + 4z + 16y), the address of the
// first child, and the materials of its voxels. Children are packed in the order of the mask. The children of a node of 16^3 are leaves: each is
// only a mask of its 4^3 voxels (two words). The last word of a node is
//
//     RX_FILLED | material     every occupied child is full, and of that material: there are no children in the buffer
//     RX_FILLED | RX_LINKED    the same of several materials: in place of the address is a link to them, as a leaf has one
//     RX_UNIFORM | material    (16^3) every voxel below is of that material
//     word                     (16^3) where the links of its leaves begin: RX_UNIFORM | material, or where the materials of the
//                              leaf's voxels are, packed in the order of its mask (packed.glsl)
//
// The idea and the 2^3 skips are from "A guide to fast voxel ray tracing using sparse 64-trees" (dubiousconst282, 2024); walk.glsl makes the
// steps, so no hit depends on rounding.
#ifdef RX_WRITE
#error "the layout `tree64` has no rx_set: nodes and leaves are packed, without room for one more; use chunks, chunk_table, octree or texture3d"
#endif

layout(std430) readonly buffer RxWorld {
#include "../header.glsl"
    uint root;            // the root node, in nodes
    uint node_count;
    uint leaf_count;
    uint unused;
    uvec4 quads[];
} world;

#define RX_QUADS
#include "../material.glsl"
#undef RX_QUADS

const uint RX_FILLED = 0x80000000u;
const uint RX_UNIFORM = 0x40000000u;
const uint RX_LINKED = 0x20000000u;
#include "../packed.glsl"

// Child of a node of height h (its cube has 4^h voxels a side) that holds cell q.
uint rx_child(uvec3 q, uint height) {
    uvec3 c = (q >> (2u * height - 2u)) & 3u;
    return c.x | (c.z << 2) | (c.y << 4);
}

// The word of a mask that holds the bit of a child.
uint rx_half(uvec2 mask, uint child) {
    return mix(mask.x, mask.y, child >= 32u);
}

bool rx_has_child(uvec2 mask, uint child) {
    return ((rx_half(mask, child) >> (child & 31u)) & 1u) != 0u;
}

// Occupied children before `child`.
uint rx_child_rank(uvec2 mask, uint child) {
    uint below = (1u << (child & 31u)) - 1u;
    return uint(bitCount(rx_half(mask, child) & below)) + mix(0u, uint(bitCount(mask.x)), child >= 32u);
}

// The 2^3 children that `child` makes an aligned cube with are empty.
bool rx_free_octet(uvec2 mask, uint child) {
    return ((rx_half(mask, child) >> (child & 10u)) & 0x00330033u) == 0u;
}

// The empty block around an empty child of 2^shift voxels a side, as rx_walk_step takes it: the upper or lower half of its parent, a layer of
// four by four children, 2^3 of them, or the child alone. Land lies in layers, and most rays go along them.
uvec3 rx_free_block(uvec2 mask, uint child, uint shift) {
    uint one = (1u << shift) - 1u, two = 2u * one + 1u, four = 4u * one + 3u, layers = rx_half(mask, child);
    if (layers == 0u) return uvec3(four, two, four);
    if (((layers >> (child & 16u)) & 0xffffu) == 0u) return uvec3(four, one, four);
    return uvec3(rx_free_octet(mask, child) ? two : one);
}

// Mask of a leaf.
uvec2 rx_leaf(uint leaf) {
    uvec4 pair = world.quads[leaf >> 1];
    return mix(pair.xy, pair.zw, bvec2((leaf & 1u) != 0u));
}

// Material of a voxel in a leaf: `rank` is the leaf's among its node's, `material` the node's last word.
uint rx_leaf_material(uint material, uint rank, uvec2 leaf, uint voxel) {
    if ((material & RX_UNIFORM) != 0u) return material & 0xffffu;
    return rx_linked_material(rx_word(material + rank), rx_child_rank(leaf, voxel));
}

// Material of a child of a filled node.
uint rx_filled_material(uvec4 node, uint child) {
    if ((node.w & RX_LINKED) == 0u) return node.w & 0xffffu;
    return rx_linked_material(node.z, rx_child_rank(node.xy, child));
}

// The node of 64^3 voxels or more around the last hit, its height, and a cell in it. After a ray, most looks are near its
// hit.
uvec3 rx_last_cell = uvec3(0x80000000u);
uint rx_last_node = 0u;
uint rx_last_height = 0u;

// As trace.glsl has it.
uint rx_look(ivec3 cell, out uint log2_free) {
    uvec3 c = uvec3(cell) - uvec3(world.origin), apart = c ^ rx_last_cell;
    bool near = ((apart.x | apart.y | apart.z) >> (2u * rx_last_height)) == 0u;
    uvec4 node = world.quads[near ? rx_last_node : world.root];
    log2_free = 0u;
    for (uint height = near ? rx_last_height : world.log2_size >> 1;; --height) {
        uint child = rx_child(c, height);
        if (!rx_has_child(node.xy, child)) {
            log2_free = 2u * height - 2u + (rx_free_octet(node.xy, child) ? 1u : 0u);
            return 0u;
        }
        if ((node.w & RX_FILLED) != 0u) return rx_filled_material(node, child);
        uint rank = rx_child_rank(node.xy, child);
        if (height == 2u) {
            uvec2 leaf = rx_leaf(node.z + rank);
            uint voxel = rx_child(c, 1u);
            if (rx_has_child(leaf, voxel)) return rx_leaf_material(node.w, rank, leaf, voxel);
            log2_free = rx_free_octet(leaf, voxel) ? 1u : 0u;
            return 0u;
        }
        node = world.quads[node.z + rank];
    }
}

// Material of a voxel; 0 is air.
uint rx_material(ivec3 cell) {
    uvec3 c = uvec3(cell) - uvec3(world.origin);
    uint log2_free;
    return ((c.x | c.y | c.z) >> world.log2_size) == 0u ? rx_look(cell, log2_free) : 0u;
}

// The node of 64^3 that rx_free passed last, and a cell in it.
uvec3 rx_chunk_cell = uvec3(0x80000000u);
uint rx_chunk_node = 0u;

// log2 of an empty aligned cube that holds cell c of the world's cube; -1 if the voxel is solid.
int rx_free(uvec3 c) {
    bool near = ((c.x ^ rx_chunk_cell.x) | (c.y ^ rx_chunk_cell.y) | (c.z ^ rx_chunk_cell.z)) < 64u;
    uint height = near ? 3u : world.log2_size >> 1;
    uint at = near ? rx_chunk_node : world.root;
    uvec4 node = world.quads[at];
    uint child = rx_child(c, height);
    bool occupied = rx_has_child(node.xy, child);
    while (occupied && height > 2u && (node.w & RX_FILLED) == 0u) {
        if (height == 3u) {
            rx_chunk_cell = c;
            rx_chunk_node = at;
        }
        at = node.z + rx_child_rank(node.xy, child);
        node = world.quads[at];
        --height;
        child = rx_child(c, height);
        occupied = rx_has_child(node.xy, child);
    }
    uvec2 mask = node.xy;
    if (occupied) {
        if ((node.w & RX_FILLED) != 0u) return -1;
        mask = rx_leaf(node.z + rx_child_rank(mask, child));
        child = rx_child(c, 1u);
        height = 1u;
        if (rx_has_child(mask, child)) return -1;
    }
    return int(2u * height - 2u) + (rx_free_octet(mask, child) ? 1 : 0);
}

// First solid voxel along a ray that passes only air until `t_free`, in lengths of its direction.
bool rx_trace_from(RxRay ray, float t_free, out RxHit hit) {
    hit = RxHit(ivec3(0), 0u, 0u, 0.0, vec2(0.0), 0u);
    RxWalk walk;
    if (!rx_walk_begin(ray, world.origin, world.log2_size, t_free, walk)) return false;
    // Mirrors the number of a child as the walk mirrors cells.
    uvec3 flip = rx_walk_flip(walk, 3u);
    uint mirror = flip.x | (flip.z << 2) | (flip.y << 4);

    uvec3 limit = rx_walk_limit(walk, world.log2_size, world.bounds_min - world.origin, world.bounds_last - world.origin);
    uvec4 node = uvec4(0u);
    uvec2 leaf = uvec2(0u);
    uint child = 0u, rank = 0u, voxel = 0u;
    uvec3 block = uvec3(0u);
    bool found = false, unsure = false;

    // The nodes of 64^3 voxels and more on the way down, by their heights. The index is dynamic, so the array is in local memory. That is faster
    // than to keep some nodes in registers, or to go down from the root again.
    uint way[16];
    uint top = world.log2_size >> 1, height = top;
    way[top] = world.root;

    // Every round leaves a block for good, and there are fewer than 3 * size blocks on a line.
    uint rounds = world.log2_size < 30u ? 4u << world.log2_size : 0xffffffffu;
    do {
        if (any(greaterThan(walk.q, limit))) break;
        height = top;
        node = world.quads[world.root];
        uint moved = 0u;  // bits of the cell that the last step changed
        for (unsure = false; !unsure && hit.steps < rounds; ++hit.steps) {
            // Up: if the ray has left the node, continue in the smallest node above that still contains it.
            if ((moved >> (2u * height)) != 0u) {
                if (any(greaterThan(walk.q, limit)) || walk.t > walk.t_end) break;
                height = max(uint(findMSB(moved) >> 1) + 1u, 3u);
                node = world.quads[way[height]];
            }

            // Down to the smallest node that holds the cell.
            child = rx_child(walk.q, height) ^ mirror;
            bool occupied = rx_has_child(node.xy, child);
            while (occupied && height > 2u && (node.w & RX_FILLED) == 0u) {
                uint at = node.z + rx_child_rank(node.xy, child);
                --height;
                way[height] = at;
                node = world.quads[at];
                child = rx_child(walk.q, height) ^ mirror;
                occupied = rx_has_child(node.xy, child);
            }
            uvec2 mask = node.xy;
            uint shift = 2u * height - 2u;
            if (occupied) {
                found = true;
                if ((node.w & RX_FILLED) != 0u) break;
                // A leaf.
                rank = rx_child_rank(node.xy, child);
                leaf = rx_leaf(node.z + rank);
                voxel = rx_child(walk.q, 1u) ^ mirror;
                found = rx_has_child(leaf, voxel);
                if (found) break;
                mask = leaf;
                child = voxel;
                shift = 0u;
            }

            block = rx_free_block(mask, child, shift);
            uvec3 before = walk.q;
            unsure = !rx_walk_step(walk, block);
            moved = (before.x ^ walk.q.x) | (before.y ^ walk.q.y) | (before.z ^ walk.q.z);
        }
        // After a step by integers the search begins again at the root: nothing else has to be kept meanwhile.
        if (unsure) rx_walk_settle(walk, ray, world.origin, world.log2_size, block);
    } while (unsure);

    if (!found) return false;
    uint steps = hit.steps + 1u;
    bool within = rx_walk_hit(walk, ray, world.origin, world.log2_size, hit);
    rx_last_cell = uvec3(hit.voxel) - uvec3(world.origin);
    rx_last_height = min(max(height, 3u), top);
    rx_last_node = way[rx_last_height];
    bool filled = (node.w & RX_FILLED) != 0u;
    hit.material = filled ? rx_filled_material(node, child) : rx_leaf_material(node.w, rank, leaf, voxel);
    hit.steps = steps;
    return within;
}

// First solid voxel along a ray, exactly; false if there is none before the ray ends.
bool rx_trace(RxRay ray, out RxHit hit) {
    return rx_trace_from(ray, 0.0, hit);
}
