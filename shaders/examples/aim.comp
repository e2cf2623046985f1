// Finds the voxel at the centre of the picture, once.
#version 460
#include <raxel/world.glsl>
#include <raxel/camera.glsl>

layout(local_size_x = 1) in;
buffer Place { ivec3 voxel; uint found; } place;

layout(push_constant) uniform Push {
    mat4 view_to_world;
    ivec3 camera_cell;
    vec3 camera_frac;
} push;

void main() {
    if (place.found != 0u) return;
    RxRay ray = rx_camera_ray(push.camera_cell, push.camera_frac, push.view_to_world, vec2(0.0), ivec2(0), ivec2(1));
    RxHit hit;
    if (!rx_trace(ray, hit)) return;
    place.voxel = hit.voxel;
    place.found = 1u;
}
