// The first voxel that the world alone shows each pixel, in tiles of 16 x 16 pixels whose rays are traced together, for see.comp.
#version 460
#include <raxel/world.glsl>
#include "../scene.glsl"
#ifdef JITTER
#define RX_TILE_PLACE pixel_place(ivec2(0))
#endif
#include <raxel/packet.glsl>
#include "first.glsl"

layout(local_size_x = 32) in;
layout(rg32ui) uniform writeonly uimage2D outFirst;

void rx_tile_hit(ivec2 pixel, ivec3 voxel, uint face) {
    imageStore(outFirst, pixel, uvec4(first_hit(uvec3(voxel - world.origin), face), 0u, 0u));
}

void rx_tile_miss(ivec2 pixel) {
    imageStore(outFirst, pixel, uvec4(first_miss(), 0u, 0u));
}

void rx_tile_rest(ivec2 pixel, float t_free) {
    imageStore(outFirst, pixel, uvec4(first_rest(t_free), 0u, 0u));
}

void main() {
    rx_trace_tile(ivec2(gl_WorkGroupID.xy), frame.camera_cell, frame.camera_frac, frame.view_to_world, frame.tan_half_fov, imageSize(outFirst));
}
