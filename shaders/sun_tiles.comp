// Finds whether the sun reaches the hit of each pixel, in packets of 16 x 16 pixels whose rays lie close together. Pixels that a packet cannot decide go into a queue.
#version 460
#include <raxel/world.glsl>
#define RX_TILE_ANY_HIT
#include <raxel/parallel.glsl>
#include "sun_ray.glsl"

layout(local_size_x = 32) in;
layout(std430) buffer RestCount { uint groups[3]; uint count; } restCount;  // what sun_rest.comp is dispatched by; entries
layout(std430) writeonly buffer Rest { uvec2 entries[]; } rest;             // 8 x 4 pixels: place of the first, and a bit for each that is left

bool rx_tile_near(ivec2 pixel, out ivec3 cell) {
    ivec4 first;
    bool goes = goes_to_sun(pixel, sun_direction(), first);
    cell = first.xyz;
    return goes;
}

bool rx_tile_start(ivec2 pixel, out ivec3 cell, out vec3 frac) {
    RxRay ray;
    bool goes = sun_ray(pixel, sun_direction(), ray);
    if (!goes) imageStore(outSun, pixel, uvec4(0u));
    cell = ray.cell;
    frac = ray.frac;
    return goes;
}

void rx_tile_hit(ivec2 pixel, ivec3 voxel, uint face) {
    imageStore(outSun, pixel, uvec4(0u));
}

void rx_tile_miss(ivec2 pixel) {
    imageStore(outSun, pixel, uvec4(1u));
}

void main() {
    const ivec2 tile = ivec2(gl_WorkGroupID.xy), size = imageSize(outSun);
    const uint lane = gl_LocalInvocationIndex;
    vec4 view[3];
    rx_camera_view(push.view_to_world, push.tan_half_fov, size, view);
    uint left = rx_trace_parallel(tile, size, sun_direction(), push.camera_cell, push.camera_frac, view);
    // Invocation s has an entry if something is left of group s.
    uint mine = 0u;
    for (uint s = 0u; s < 8u; ++s) {
        uint of_group = RX_TILE_BALLOT(((left >> s) & 1u) != 0u);
        if (lane == s) mine = of_group;
    }
    uint some = RX_TILE_BALLOT(mine != 0u), count = uint(bitCount(some)), at = 0u;
    if (lane == 0u && some != 0u) {
        // Atomic operations on one word run one after the other, so nearly all tiles make only one. They add workgroups for 64 entries at a time.
        at = atomicAdd(restCount.count, count);
        if (at == 0u) {
            restCount.groups[1] = 1u;
            restCount.groups[2] = 1u;
        }
        if (at == 0u || at / 64u != (at + count) / 64u) atomicMax(restCount.groups[0], min(((at + count) / 64u + 1u) * 32u, 65535u));
    }
    at = RX_TILE_READ(at, 0u) + uint(bitCount(some & ((1u << lane) - 1u)));
    ivec2 first = tile * RX_TILE + ivec2(8u * (lane & 1u), 4u * (lane >> 1));
    if (mine != 0u) rest.entries[at] = uvec2(uint(first.x) | (uint(first.y) << 16), mine);
}
