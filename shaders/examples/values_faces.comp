// Each face of a voxel in the colour that the graph's table has for it.
#version 460
#include <raxel/world.glsl>
#include <raxel/camera.glsl>

layout(local_size_x = 8, local_size_y = 8) in;
layout(std430) readonly buffer Palette { vec3 palette[]; };
layout(rgba16f) uniform writeonly image2D outColor;

layout(push_constant) uniform Push {
    mat4 view_to_world;
    ivec3 camera_cell;
    vec3 camera_frac;
    vec2 tan_half_fov;
} push;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    ivec2 size = imageSize(outColor);
    if (any(greaterThanEqual(pixel, size))) return;
    RxRay ray = rx_camera_ray(push.camera_cell, push.camera_frac, push.view_to_world, push.tan_half_fov, pixel, size);
    RxHit hit;
    vec3 color = rx_trace(ray, hit) ? palette[hit.face] : vec3(0.02);
    imageStore(outColor, pixel, vec4(color, 1.0));
}
