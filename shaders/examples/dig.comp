// Takes a ball of voxels out of the copy: one thread for each voxel around its centre.
#version 460
#define RX_WRITE_world
#include <raxel/world.glsl>

layout(local_size_x = 4, local_size_y = 4, local_size_z = 4) in;
readonly buffer Place { ivec3 voxel; uint found; } place;

layout(push_constant) uniform Push {
    float radius;  // voxels, at most 32
} push;

void main() {
    ivec3 offset = ivec3(gl_GlobalInvocationID) - ivec3(gl_NumWorkGroups * gl_WorkGroupSize) / 2;
    if (place.found == 0u || dot(vec3(offset), vec3(offset)) > push.radius * push.radius) return;
    rx_set(place.voxel + offset, 0u);
}
