// The voxels of the box that water cannot enter. Made when the world changes.
#version 460
#include <raxel/world.glsl>

layout(local_size_x = 4, local_size_y = 4, local_size_z = 4) in;
layout(r8ui) uniform writeonly uimage3D outWalls;
layout(push_constant) uniform Push { ivec3 corner; } push;

void main() {
    ivec3 voxel = ivec3(gl_GlobalInvocationID);
    if (any(greaterThanEqual(voxel, imageSize(outWalls)))) return;
    imageStore(outWalls, voxel, uvec4(rx_material(push.corner + voxel) != 0u ? 1u : 0u));
}
