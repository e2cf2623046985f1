// The first voxel along each pixel's ray through the copy, in the light of sun and sky.
#version 460
#include <raxel/world.glsl>
#include <raxel/camera.glsl>
#include <raxel/shade.glsl>

layout(local_size_x = 8, local_size_y = 8) in;
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

    vec3 sun = rx_sun_direction(215.0, 40.0);
    RxRay ray = rx_camera_ray(push.camera_cell, push.camera_frac, push.view_to_world, push.tan_half_fov, pixel, size);
    RxHit hit;
    vec3 color = rx_sky(ray.dir, sun);
    if (rx_trace(ray, hit) && hit.face != RX_FACE_INSIDE) {
        vec3 normal = rx_normal(hit.face);
        vec3 light = 0.6 * rx_openness(hit) * rx_ambient(normal, sun) + 1.5 * max(dot(normal, sun), 0.0) * rx_sun_color(sun);
        color = rx_material_properties(hit.material).albedo * light;
    }
    imageStore(outColor, pixel, vec4(rx_tone_curve(color), 1.0));
}
