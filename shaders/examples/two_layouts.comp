// Each pixel's ray through two worlds, `world` and `other`, and the difference of the two hits.
#version 460
#include <raxel/world.glsl>
#include <raxel/world/other.glsl>
#include <raxel/camera.glsl>

layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba16f) uniform writeonly image2D outPicture;      // left of the split the world, right of it the difference
layout(r32ui) uniform writeonly uimage2D outDifference;    // bits, see differences()

layout(push_constant) uniform Push {
    mat4 view_to_world;
    ivec3 camera_cell;
    float split;
    vec3 camera_frac;
    vec2 tan_half_fov;
} push;

uint differences(bool in_a, RxHit a, bool in_b, RxHit b) {
    if (in_a != in_b) return 1u;
    if (!in_a) return 0u;
    return (a.voxel != b.voxel ? 2u : 0u) | (a.face != b.face ? 4u : 0u) | (a.material != b.material ? 8u : 0u) |
           (a.t != b.t ? 16u : 0u) | (a.uv != b.uv ? 32u : 0u);
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    ivec2 size = imageSize(outPicture);
    if (any(greaterThanEqual(pixel, size))) return;

    RxRay ray = rx_camera_ray(push.camera_cell, push.camera_frac, push.view_to_world, push.tan_half_fov, pixel, size);
    RxHit a, b;
    bool in_a = rx_trace(ray, a), in_b = other_trace(ray, b);
    uint bits = differences(in_a, a, in_b, b);
    imageStore(outDifference, pixel, uvec4(bits));

    vec3 color = bits == 0u ? vec3(0.0) : vec3(1.0, 0.2, 0.1);
    if (float(pixel.x) < push.split * float(size.x)) {
        // Half of the colour by one world's material, half by the other's.
        vec3 albedo = 0.5 * (rx_material_properties(a.material).albedo + other_material_properties(b.material).albedo);
        color = in_a ? albedo * (0.65 + 0.35 * dot(rx_normal(a.face), vec3(0.3, 0.8, 0.5))) : vec3(0.35, 0.5, 0.7);
    }
    imageStore(outPicture, pixel, vec4(color, 1.0));
}
