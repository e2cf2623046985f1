// Layout `tree64`: a sparse tree in which every node splits its cube into 4 x 4 x 4.
//
// A node is three words: a mask of its occupied children (two words; child x + 4z + 16y), and a link. With the top bit set, every
// occupied child is filled with the material in the link's low 16 bits. Otherwise the link of a node of voxels says where the
// materials of its voxels begin (in halfwords), and that of any other node where its occupied children begin (in words);
// both are packed without gaps, in the order of the mask.
//
// The idea and the 2^3 skips are from "A guide to fast voxel ray tracing using sparse 64-trees" (dubiousconst282, 2024); the
// stepping is walk.glsl's, so no hit depends on rounding.
#ifndef RAXEL_TREE64_GLSL
#define RAXEL_TREE64_GLSL

layout(std430) readonly buffer RxWorld {
    ivec3 origin;         // smallest corner of the root's cube
    uint log2_size;       // the cube has 2^log2_size voxels a side
    ivec3 bounds_min;     // smallest and largest coordinates of solid voxels
    uint material_count;
    ivec3 bounds_last;
    uint materials_at;    // word of the first material
    uint root;            // word of the root node
    uint node_count;
    uint attributes_at;   // word where the materials of voxels begin
    uint attribute_count; // in halfwords
    uint words[];
} world;

#include "material.glsl"

const uint RX_SOLID_LINK = 0x80000000u;

// Child of a node of height h (its cube has 4^h voxels a side) that holds cell q.
uint rx_child(uvec3 q, uint height) {
    uvec3 c = (q >> (2u * height - 2u)) & 3u;
    return c.x | (c.z << 2) | (c.y << 4);
}

bool rx_has_child(uvec2 mask, uint child) {
    return (((child >= 32u ? mask.y : mask.x) >> (child & 31u)) & 1u) != 0u;
}

// Occupied children before `child`.
uint rx_child_rank(uvec2 mask, uint child) {
    uint below = (1u << (child & 31u)) - 1u;
    return child >= 32u ? uint(bitCount(mask.x) + bitCount(mask.y & below)) : uint(bitCount(mask.x & below));
}

// Material of an occupied child that is a voxel, or in a node with RX_SOLID_LINK.
uint rx_child_material(uint link, uvec2 mask, uint child) {
    if ((link & RX_SOLID_LINK) != 0u) return link & 0xffffu;
    uint half_word = link + rx_child_rank(mask, child);
    return (world.words[half_word >> 1] >> ((half_word & 1u) * 16u)) & 0xffffu;
}

uint rx_material(ivec3 cell) {
    uvec3 c = uvec3(cell) - uvec3(world.origin);
    if (any(greaterThanEqual(c, uvec3(1u << world.log2_size)))) return 0u;
    uint node = world.root;
    for (uint height = world.log2_size >> 1; height > 0u; --height) {
        uvec2 mask = uvec2(world.words[node], world.words[node + 1u]);
        uint link = world.words[node + 2u];
        uint child = rx_child(c, height);
        if (!rx_has_child(mask, child)) return 0u;
        if (height == 1u || (link & RX_SOLID_LINK) != 0u) return rx_child_material(link, mask, child);
        node = link + 3u * rx_child_rank(mask, child);
    }
    return 0u;
}

bool rx_trace(RxRay ray, out RxHit hit) {
    hit = RxHit(ivec3(0), 0u, 0u, 0.0, vec2(0.0), 0u);
    RxWalk walk;
    if (!rx_walk_begin(ray, world.origin, world.log2_size, walk)) return false;
    float t_end = rx_walk_t_end(walk, ray);
    uint outside = ~((1u << world.log2_size) - 1u);
    uint mirror = (walk.flip.x & 3u) | ((walk.flip.z & 3u) << 2) | ((walk.flip.y & 3u) << 4);

    uint ancestors[16];
    uint height = world.log2_size >> 1;
    uint node = world.root;
    uvec2 mask = uvec2(world.words[node], world.words[node + 1u]);
    uint link = world.words[node + 2u];
    uvec3 path = walk.q;  // the cell that `ancestors` lead to
    uint child = 0u, shift = 0u;
    bool found = false, unsure = false;

    // Every round leaves a block for good, and there are fewer than 3 * size blocks on a line.
    uint rounds = world.log2_size < 30u ? 4u << world.log2_size : 0xffffffffu;
    do {
        for (unsure = false; !unsure && hit.steps < rounds; ++hit.steps) {
            if (((walk.q.x | walk.q.y | walk.q.z) & outside) != 0u || walk.t > t_end) break;

            // Up to the smallest node that holds both the cell before and this one.
            uvec3 changed = path ^ walk.q;
            uint top = uint(findMSB(changed.x | changed.y | changed.z | 1u)) / 2u + 1u;
            if (top > height) {
                height = top;
                node = ancestors[height];
                mask = uvec2(world.words[node], world.words[node + 1u]);
                link = world.words[node + 2u];
            }
            path = walk.q;

            // Down to the smallest node or filled cube that holds it.
            child = rx_child(walk.q, height) ^ mirror;
            found = rx_has_child(mask, child);
            while (found && height > 1u && (link & RX_SOLID_LINK) == 0u) {
                ancestors[height] = node;
                node = link + 3u * rx_child_rank(mask, child);
                --height;
                mask = uvec2(world.words[node], world.words[node + 1u]);
                link = world.words[node + 2u];
                child = rx_child(walk.q, height) ^ mirror;
                found = rx_has_child(mask, child);
            }
            if (found) break;

            // The cell is empty; often so are the seven that make a cube of twice its size with it.
            uint corner = child & 42u;
            uint half_mask = corner >= 32u ? mask.y : mask.x;
            shift = 2u * height - 2u + (((half_mask >> (corner & 31u)) & 0x00330033u) == 0u ? 1u : 0u);
            unsure = !rx_walk_step(walk, shift);
        }
        if (unsure) rx_walk_settle(walk, shift);
    } while (unsure);

    if (!found) return false;
    uint steps = hit.steps + 1u;
    bool within = rx_walk_hit(walk, ray, world.origin, hit);
    hit.material = rx_child_material(link, mask, child);
    hit.steps = steps;
    return within;
}

#endif
