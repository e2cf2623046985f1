// The first voxel along each pixel's ray: of the world, or of a model that hangs before the camera, whichever is nearer.
#version 460
#include <raxel/world.glsl>
#include <raxel/world/pine.glsl>
#include <raxel/camera.glsl>
#include <raxel/shade.glsl>

layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba16f) uniform writeonly image2D outColor;

layout(push_constant) uniform Push {
    mat4 view_to_world;
    ivec3 camera_cell;
    float distance;  // voxels
    vec3 camera_frac;
    float turn;      // radians
    vec2 tan_half_fov;
} push;

vec3 turned(vec3 v) {
    float c = cos(push.turn), s = sin(push.turn);
    return vec3(c * v.x + s * v.z, v.y, c * v.z - s * v.x);
}

// The pixel's ray in the model's frame: the centre of the model lies `distance` before the camera, upright in the picture.
RxRay ray_to_model(ivec2 pixel, ivec2 size) {
    vec3 dir = rx_camera_direction(mat4(1.0), push.tan_half_fov, vec2(pixel) + 0.5, vec2(size));
    vec3 middle = 0.5 * vec3(pine.bounds_min + pine.bounds_last + 1);
    vec3 from = middle + turned(vec3(0.0, 0.0, push.distance));
    return rx_ray(ivec3(floor(from)), fract(from), turned(dir));
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    ivec2 size = imageSize(outColor);
    if (any(greaterThanEqual(pixel, size))) return;

    vec3 sun = rx_sun_direction(215.0, 40.0);
    RxRay ray = rx_camera_ray(push.camera_cell, push.camera_frac, push.view_to_world, push.tan_half_fov, pixel, size);
    RxHit in_world, in_model;
    bool world_hit = rx_trace(ray, in_world);
    bool model_hit = pine_trace(ray_to_model(pixel, size), in_model);
    vec3 color = rx_sky(ray.dir, sun);
    if (model_hit && (!world_hit || in_model.t < in_world.t)) {
        float facing = 0.6 + 0.4 * dot(rx_normal(in_model.face), normalize(vec3(0.5, 0.8, 0.6)));
        color = pine_material_properties(in_model.material).albedo * facing;
    } else if (world_hit && in_world.face != RX_FACE_INSIDE) {
        vec3 normal = rx_normal(in_world.face);
        color = rx_material_properties(in_world.material).albedo * (0.4 * rx_ambient(normal, sun) + max(dot(normal, sun), 0.0));
    }
    imageStore(outColor, pixel, vec4(rx_tone_curve(color), 1.0));
}
