// Lum's blocks that are copied before they are written. A block of 16³ voxels that an instance touches has a slot: its voxels are copied there, and the
// instance is drawn over them. All other blocks are those of the world. Needs the block `grid` of field.glsl.
#include <raxel/internal/walk.glsl>
#include "block.glsl"

uniform usampler3D slots;   // for each block of the world: its slot + 1, or 0
layout(std430) readonly buffer Blocks { Block blocks[]; };

// Log2 of the size of the smallest cube that holds the grid of blocks, in voxels.
uint blocks_log2_size() {
    ivec3 size = textureSize(slots, 0);
    return 5u + uint(findMSB(max(size.x, max(size.y, size.z))));
}

// The material of a voxel of a copied block, counted from the smallest corner of the world; or 0, and the log2 of a free cube around it.
uint blocks_look(uvec3 cell, out uint log2_free) {
    log2_free = 4u;
    uint slot = texelFetch(slots, ivec3(cell >> 4u), 0).x;
    if (slot == 0u) return 0u;
    log2_free = 0u;
    uvec3 within = cell & 15u;
    return blocks[slot - 1u].voxels[within.x | within.y << 4 | within.z << 8] & 0xffffu;
}

// The first solid voxel of a copied block along a ray, by the walk that all tracers share.
bool trace_blocks(RxRay ray, out RxHit hit) {
    hit = RxHit(ivec3(0), 0u, 0u, 0.0, vec2(0.0), 0u);
    uint log2_size = blocks_log2_size();
    RxWalk walk;
    if (!rx_walk_begin(ray, grid.world_min, log2_size, 0.0, walk)) return false;
    uvec3 flip = rx_walk_flip(walk, (1u << log2_size) - 1u);
    uvec3 limit = rx_walk_limit(walk, log2_size, ivec3(0), 16 * textureSize(slots, 0) - 1);
    uint log2_free = 0u, material = 0u, rounds = 4u << log2_size;
    bool unsure = false;
    do {
        for (unsure = false; !unsure && hit.steps < rounds; ++hit.steps) {
            if (any(greaterThan(walk.q, limit)) || walk.t > walk.t_end) break;
            material = blocks_look(walk.q ^ flip, log2_free);
            if (material != 0u) break;
            unsure = !rx_walk_step(walk, log2_free);
        }
        if (unsure) rx_walk_settle(walk, ray, grid.world_min, log2_size, log2_free);
    } while (unsure);
    if (material == 0u) return false;
    uint steps = hit.steps + 1u;
    bool within = rx_walk_hit(walk, ray, grid.world_min, log2_size, hit);
    hit.material = material;
    hit.steps = steps;
    return within;
}
