// Layout `chunks`: a list of 32^3 chunks, each a flat array of voxels, searched from its start for every voxel that is asked for.
// The simplest way to hold a sparse world, and a slow one: kept as the baseline that the trees are measured against.
#ifndef RAXEL_CHUNKS_GLSL
#define RAXEL_CHUNKS_GLSL

layout(std430) readonly buffer RxWorld {
    ivec3 origin;         // smallest corner of a cube around the world
    uint log2_size;       // the cube has 2^log2_size voxels a side
    ivec3 bounds_min;     // smallest and largest coordinates of solid voxels
    uint material_count;
    ivec3 bounds_last;
    uint materials_at;    // word of the first material
    uint chunks_at;       // word of the first chunk: 4 words each, x, y, z in chunks, and the word where its voxels begin
    uint chunk_count;
    uint voxels_at;       // word of the first voxel: two a word, x + 32y + 1024z in a chunk
    uint voxel_chunks;    // chunks of voxels; equal chunks share them
    uint words[];
} world;

#include "material.glsl"

const uint RX_NO_CHUNK = 0xffffffffu;

bool rx_is_chunk(uint i, ivec3 chunk) {
    uint at = world.chunks_at + 4u * i;
    return int(world.words[at]) == chunk.x && int(world.words[at + 1u]) == chunk.y && int(world.words[at + 2u]) == chunk.z;
}

// Word where the voxels of the chunk at `chunk` (in chunks) begin. Four chunks a round: software drivers of the llvmpipe family end
// every loop when those of one invocation have made 65,535 rounds together.
uint rx_find_chunk(ivec3 chunk) {
    uint last = max(world.chunk_count, 1u) - 1u;
    for (uint i = 0u; i < world.chunk_count; i += 4u) {
        uvec4 four = min(uvec4(i) + uvec4(0u, 1u, 2u, 3u), uvec4(last));
        uint found = RX_NO_CHUNK;
        if (rx_is_chunk(four.x, chunk)) found = four.x;
        if (rx_is_chunk(four.y, chunk)) found = four.y;
        if (rx_is_chunk(four.z, chunk)) found = four.z;
        if (rx_is_chunk(four.w, chunk)) found = four.w;
        if (found != RX_NO_CHUNK) return world.words[world.chunks_at + 4u * found + 3u];
    }
    return RX_NO_CHUNK;
}

uint rx_chunk_voxel(uint voxels, ivec3 cell) {
    uvec3 c = uvec3(cell) & 31u;
    uint index = c.x + 32u * c.y + 1024u * c.z;
    return (world.words[voxels + (index >> 1)] >> ((index & 1u) * 16u)) & 0xffffu;
}

uint rx_material(ivec3 cell) {
    if (any(lessThan(cell, world.bounds_min)) || any(greaterThan(cell, world.bounds_last))) return 0u;
    uint voxels = rx_find_chunk(cell >> 5);
    return voxels == RX_NO_CHUNK ? 0u : rx_chunk_voxel(voxels, cell);
}

bool rx_trace(RxRay ray, out RxHit hit) {
    hit = RxHit(ivec3(0), 0u, 0u, 0.0, vec2(0.0), 0u);
    RxWalk walk;
    if (!rx_walk_begin(ray, world.origin, world.log2_size, walk)) return false;
    float t_end = rx_walk_t_end(walk, ray);
    uint outside = ~((1u << world.log2_size) - 1u);

    // Every round leaves a block for good, and there are fewer than 3 * size blocks on a line.
    uint rounds = world.log2_size < 30u ? 4u << world.log2_size : 0xffffffffu;
    uvec3 chunk = uvec3(0xffffffffu);
    uint voxels = RX_NO_CHUNK;
    for (uint i = 1u; i < rounds; ++i) {
        ivec3 cell = world.origin + ivec3(walk.q ^ walk.flip);
        if (any(notEqual(walk.q >> 5, chunk))) {
            chunk = walk.q >> 5;
            voxels = rx_find_chunk(cell >> 5);
        }
        uint material = voxels == RX_NO_CHUNK ? 0u : rx_chunk_voxel(voxels, cell);
        if (material != 0u) {
            bool within = rx_walk_hit(walk, ray, world.origin, hit);
            hit.material = material;
            hit.steps = i;
            return within;
        }
        rx_walk_step(walk, voxels == RX_NO_CHUNK ? 5u : 0u);
        hit.steps = i;
        if (((walk.q.x | walk.q.y | walk.q.z) & outside) != 0u || walk.t > t_end) return false;
    }
    return false;
}

#endif
