// Finds the first hit of each pixel, in packets of 16 x 16 pixels. Pixels that a packet cannot decide go into a queue.
#version 460
#include <raxel/world.glsl>
#include <raxel/packet.glsl>

layout(local_size_x = 32) in;
layout(rgba32i) uniform writeonly iimage2D outHit;  // voxel; face, or -1 where nothing is hit
layout(std430) buffer RestCount { uint groups[3]; uint count; } restCount;  // the dispatch of packet_rest.comp; pixels
layout(std430) writeonly buffer Rest { uvec2 pixels[]; } rest;  // pixel, time until which its ray is free

layout(push_constant) uniform Push {
    mat4 view_to_world;
    ivec3 camera_cell;
    vec3 camera_frac;
    vec2 tan_half_fov;
} push;

void rx_tile_hit(ivec2 pixel, ivec3 voxel, uint face) {
    imageStore(outHit, pixel, ivec4(voxel, face));
}

void rx_tile_miss(ivec2 pixel) {
    imageStore(outHit, pixel, ivec4(0, 0, 0, -1));
}

void rx_tile_rest(ivec2 pixel, float t_free) {
    uint i = atomicAdd(restCount.count, 1u);
    rest.pixels[i] = uvec2(uint(pixel.x) | (uint(pixel.y) << 16), floatBitsToUint(t_free));
    // The first of 64 pixels makes room for all of them, because atomic operations on one word run one after the other.
    if (i % 64u == 0u) atomicMax(restCount.groups[0], min(i / 64u + 1u, 65535u));
    if (i == 0u) {
        restCount.groups[1] = 1u;
        restCount.groups[2] = 1u;
    }
}

void main() {
    rx_trace_tile(ivec2(gl_WorkGroupID.xy), push.camera_cell, push.camera_frac, push.view_to_world, push.tan_half_fov, imageSize(outHit));
}
