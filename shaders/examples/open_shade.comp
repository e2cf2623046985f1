// The picture, lit by the part of the sky that is visible from each place.
#version 460
#include <raxel/world.glsl>
#include <raxel/camera.glsl>
#include <raxel/shade.glsl>

layout(local_size_x = 8, local_size_y = 8) in;
uniform sampler3D open;
layout(rgba16f) uniform writeonly image2D outColor;

layout(push_constant) uniform Push {
    mat4 view_to_world;
    ivec3 camera_cell;
    vec3 camera_frac;
    vec2 tan_half_fov;
    ivec3 world_min;
} push;

const float SCALE = 0.0625;  // texels a voxel: the scale of the target's size

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    ivec2 size = imageSize(outColor);
    if (any(greaterThanEqual(pixel, size))) return;
    RxRay ray = rx_camera_ray(push.camera_cell, push.camera_frac, push.view_to_world, push.tan_half_fov, pixel, size);
    RxHit hit;
    vec3 color = vec3(0.45, 0.65, 0.9);
    if (rx_trace(ray, hit)) {
        vec3 normal = rx_normal(hit.face);
        // Half a texel away from the face, so that the ground does not darken itself.
        vec3 place = vec3(hit.voxel - push.world_min) + 0.5 + normal * (0.5 / SCALE);
        float sky = texture(open, place * SCALE / vec3(textureSize(open, 0))).r;
        color = rx_material_properties(hit.material).albedo * (0.15 + sky) * (0.75 + 0.25 * normal.y);
    }
    imageStore(outColor, pixel, vec4(color, 1.0));
}
