// Shows the world or the micro-voxels, whichever the ray meets first. The sun lights a place if neither blocks it.
#version 460
#include <raxel/world.glsl>
#include <raxel/micro.glsl>
#include <raxel/camera.glsl>
#include <raxel/shade.glsl>

layout(local_size_x = 8, local_size_y = 8) in;
uniform usampler3D micro;
layout(std430) readonly buffer Spot { ivec3 corner; uint put; } spot;
layout(rgba16f) uniform writeonly image2D outColor;
layout(push_constant) uniform Push {
    mat4 view_to_world;
    ivec3 camera_cell;
    vec3 camera_frac;
    vec2 tan_half_fov;
} push;

// A ray's hit in the world, and its hit on the lattice of micro-voxels.
bool meets(RxRay in_world, RxRay in_micro, out RxHit hit, out bool small) {
    RxHit other;
    bool found = rx_trace(in_world, hit);
    // A time on the finer lattice is 4 times that in the world, to the last bit, so the first of both is exact, too.
    if (found) in_micro.t_max = 4.0 * hit.t;
    small = rx_trace_micro(micro, spot.corner, in_micro, other);
    if (small) hit = other;
    return found || small;
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), size = imageSize(outColor);
    if (any(greaterThanEqual(pixel, size))) return;
    vec3 dir = rx_camera_direction(push.view_to_world, push.tan_half_fov, vec2(pixel) + 0.5, vec2(size));
    vec3 sun = rx_sun_direction(215.0, 42.0), color = rx_sky(dir, sun);
    RxRay ray = rx_ray(push.camera_cell, push.camera_frac, dir);
    RxHit hit, in_the_way;
    bool small, unused;
    if (meets(ray, rx_micro_ray(ray), hit, small)) {
        vec3 normal = rx_normal(hit.face), albedo = small ? vec3(0.62, 0.26, 0.06) : rx_material_properties(hit.material).albedo;
        float light = max(dot(normal, sun), 0.0);
        if (light > 0.0) {
            RxRay on = rx_ray_from_face(hit.voxel, hit.face, hit.uv, sun);
            // Each ray begins exactly on the face, on the lattice of the voxel or micro-voxel that it leaves.
            if (small ? meets(rx_world_ray(on), on, in_the_way, unused) : meets(on, rx_micro_ray(on), in_the_way, unused)) light = 0.0;
        }
        color = albedo * (2.3 * light * rx_sun_color(sun) + 0.6 * rx_ambient(normal, sun));
    }
    imageStore(outColor, pixel, vec4(rx_tone_curve(0.85 * color), 1.0));
}
