// Layout `chunks`: a list of 32^3 chunks, each a flat array of voxels, searched from its start for every voxel that is asked for.
// The simplest way to hold a sparse world, and a slow one: kept as the baseline that the trees are measured against.
layout(std430) RX_WORLD_ACCESS buffer RxWorld {
#include <raxel/internal/header.glsl>
    uint chunks_at;       // word of the list: a key of each chunk, then 4 words each, x, y, z in chunks, and the word of its voxels
    uint chunk_count;
    uint voxels_at;       // word of the first voxel: two a word, x + 32y + 1024z in a chunk
    uint voxel_chunks;    // chunks of voxels; equal chunks share them
    uint words[];
} world;

#include <raxel/internal/material.glsl>

const uint RX_NO_CHUNK = 0xffffffffu;

// The chunk that this thread asked for last: a ray stays in a chunk for many samples.
ivec3 rx_last_chunk = ivec3(0x7fffffff);
uint rx_last_voxels = RX_NO_CHUNK;

// Ten bits of each coordinate of a chunk.
uint rx_chunk_key(ivec3 chunk) {
    uvec3 low = uvec3(chunk) & 1023u;
    return low.x | (low.y << 10) | (low.z << 20);
}

bvec4 rx_keys_equal(uint i, uint key) {
    uvec4 at = world.chunks_at + min(i + uvec4(0u, 1u, 2u, 3u), uvec4(world.chunk_count - 1u));
    return equal(uvec4(world.words[at.x], world.words[at.y], world.words[at.z], world.words[at.w]), uvec4(key));
}

// Word where the voxels of the chunk at `chunk` (in chunks) begin. The keys are compared sixteen a round, since software drivers
// of the llvmpipe family end every loop when those of one invocation have made 65,535 rounds together.
uint rx_search_chunk(ivec3 chunk) {
    if (any(lessThan(chunk, world.bounds_min >> 5)) || any(greaterThan(chunk, world.bounds_last >> 5))) return RX_NO_CHUNK;
    uint key = rx_chunk_key(chunk);
    uint count = world.chunk_count;
    for (uint i = 0u; i < count; i += 16u) {
        bvec4 a = rx_keys_equal(i, key), b = rx_keys_equal(i + 4u, key);
        bvec4 c = rx_keys_equal(i + 8u, key), d = rx_keys_equal(i + 12u, key);
        if (!(any(a) || any(b) || any(c) || any(d))) continue;
        // Worlds of more than 1024 chunks a side have equal keys.
        for (uint k = i; k < min(i + 16u, count); ++k) {
            uint at = world.chunks_at + count + 4u * k;
            if (ivec3(world.words[at], world.words[at + 1u], world.words[at + 2u]) == chunk) return world.words[at + 3u];
        }
    }
    return RX_NO_CHUNK;
}

// The same, and at once for the chunk that was asked for last.
uint rx_find_chunk(ivec3 chunk) {
    if (chunk != rx_last_chunk) {
        rx_last_chunk = chunk;
        rx_last_voxels = rx_search_chunk(chunk);
    }
    return rx_last_voxels;
}

// Number of a voxel in its chunk.
uint rx_chunk_index(ivec3 cell) {
    uvec3 c = uvec3(cell) & 31u;
    return c.x + 32u * c.y + 1024u * c.z;
}

uint rx_chunk_voxel(uint voxels, ivec3 cell) {
    uint index = rx_chunk_index(cell);
    return (world.words[voxels + (index >> 1)] >> ((index & 1u) * 16u)) & 0xffffu;
}

// A chunk is looked for once; then the ray walks as far as it is in it, voxel by voxel.
uint rx_look(ivec3 cell, out uint log2_free) {
    uint voxels = rx_find_chunk(cell >> 5);
    log2_free = voxels == RX_NO_CHUNK ? 5u : 0u;
    return voxels == RX_NO_CHUNK ? 0u : rx_chunk_voxel(voxels, cell);
}

#include <raxel/internal/trace.glsl>

#ifdef RX_WRITE
#include "../store.glsl"

// A voxel of a chunk of the copy. Only the voxels themselves mark solid ones.
bool rx_set(ivec3 cell, uint material) {
    uint voxels = rx_find_chunk(cell >> 5);
    if (voxels == RX_NO_CHUNK) return false;
    uint index = rx_chunk_index(cell);
    return rx_store_voxel(voxels + (index >> 1), index & 1u, material);
}
#endif
