// Writes the water into a copy of the world: a voxel is water if the mean density of its eight cubes is above one half; otherwise it is empty.
// Water is the first clear material of the world, or the first material if none is clear.
#version 460
#define RX_WRITE_world
#include <raxel/world.glsl>
#include "clear.glsl"

layout(local_size_x = 4, local_size_y = 4, local_size_z = 4) in;
uniform usampler3D walls;
uniform sampler3D field;
layout(push_constant) uniform Push { ivec3 corner; } push;

void main() {
    ivec3 voxel = ivec3(gl_GlobalInvocationID);
    if (any(greaterThanEqual(voxel, textureSize(walls, 0))) || texelFetch(walls, voxel, 0).x != 0u) return;
    float sum = 0.0;
    for (int i = 0; i < 8; ++i) sum += texelFetch(field, 2 * voxel + ivec3(i & 1, i >> 1 & 1, i >> 2), 0).x;
    rx_set(push.corner + voxel, sum > 4.0 ? clear_material() : 0u);
}
