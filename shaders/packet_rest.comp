// Finds the first hit of each pixel in the queue, ray by ray.
#version 460
#include <raxel/world.glsl>
#include <raxel/camera.glsl>

layout(local_size_x = 64) in;
layout(rgba32i) uniform writeonly iimage2D outHit;
layout(std430) readonly buffer RestCount { uint groups[3]; uint count; } restCount;
layout(std430) readonly buffer Rest { uvec2 pixels[]; } rest;

layout(push_constant) uniform Push {
    mat4 view_to_world;
    ivec3 camera_cell;
    vec3 camera_frac;
    vec2 tan_half_fov;
} push;

void main() {
    // There may be more pixels than one row of workgroups has threads.
    for (uint i = gl_GlobalInvocationID.x; i < restCount.count; i += 64u * gl_NumWorkGroups.x) {
        uvec2 left = rest.pixels[i];
        ivec2 pixel = ivec2(left.x & 0xffffu, left.x >> 16);
        RxHit hit;
        RxRay ray = rx_camera_ray(push.camera_cell, push.camera_frac, push.view_to_world, push.tan_half_fov, pixel, imageSize(outHit));
        bool found = rx_trace_from(ray, uintBitsToFloat(left.y), hit);
        imageStore(outHit, pixel, found ? ivec4(hit.voxel, hit.face) : ivec4(0, 0, 0, -1));
    }
}
