// Digs a ball around the first voxel along one ray. The pass runs again when the world has changed, and so the hole grows.
#version 460
#include <raxel/world.glsl>
#include <raxel/camera.glsl>
#include <raxel/edits.glsl>

layout(local_size_x = 1) in;

layout(push_constant) uniform Push {
    mat4 view_to_world;
    ivec3 camera_cell;
    vec3 camera_frac;
    vec2 tan_half_fov;
    vec2 place;  // parts of the picture, from its top left
    float radius;
    float reach;
} push;

void main() {
    ivec2 size = ivec2(1 << 12);
    ivec2 pixel = ivec2(push.place * vec2(size));
    RxRay ray = rx_camera_ray(push.camera_cell, push.camera_frac, push.view_to_world, push.tan_half_fov, pixel, size);
    RxHit hit;
    if (rx_trace(ray, hit) && hit.t <= push.reach) rx_edit_sphere(hit.voxel, push.radius, RX_EDIT_SUBTRACT, 0u);
}
