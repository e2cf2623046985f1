// Puts the instances of the world where the birds are: heading along their flight, leaning into their turns.
#version 460
#include <raxel/instance_block.glsl>
#include <raxel/poses.glsl>

layout(local_size_x = 64) in;

struct Bird {
    vec4 place;     // voxels
    vec4 velocity;  // voxels a second, and the lean to the right, -1 to 1
};
layout(std430) readonly buffer Birds { Bird birds[]; };

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= uint(birds.length()) || i >= instances.count) return;
    vec3 place = birds[i].place.xyz, velocity = birds[i].velocity.xyz;
    if (velocity == vec3(0.0)) return;
    // The model flies towards -Z.
    float yaw = degrees(atan(-velocity.x, -velocity.z));
    float pitch = degrees(asin(clamp(velocity.y / length(velocity), -1.0, 1.0)));
    vec3 cell = floor(place);
    rx_pose_set(i, ivec3(cell), place - cell, yaw, pitch, -40.0 * birds[i].velocity.w);
}
