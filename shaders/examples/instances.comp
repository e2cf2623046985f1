// The world and its instances as each pixel sees them, lit by the sun and the sky.
//
// The ray to the sun takes its turn in the same loop. GLSL inlines every call, so this compiles the tracer once.
#version 460
#include <raxel/instances.glsl>
#include <raxel/camera.glsl>
#include <raxel/shade.glsl>

layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba16f) uniform writeonly image2D outColor;
layout(r32ui) uniform writeonly uimage2D outInstance;

layout(push_constant) uniform Push {
    mat4 view_to_world;
    ivec3 camera_cell;
    float sun_azimuth;
    vec3 camera_frac;
    float sun_elevation;
    vec2 tan_half_fov;
} push;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    ivec2 size = imageSize(outColor);
    if (any(greaterThanEqual(pixel, size))) return;

    vec3 sun = rx_sun_direction(push.sun_azimuth, push.sun_elevation);
    RxRay ray = rx_camera_ray(push.camera_cell, push.camera_frac, push.view_to_world, push.tan_half_fov, pixel, size);
    RxSceneRay next = rx_scene_ray(ray);
    RxSceneHit hit, seen;
    vec3 normal = vec3(0.0);
    bool found = false, sunlit = false;
    for (int turn = 0; turn < 2; ++turn) {
        bool meets = rx_trace_scene(next, hit);
        if (turn == 1) {
            sunlit = !meets;
            break;
        }
        if (!meets) break;
        found = true;
        seen = hit;
        normal = rx_scene_normal(seen);
        // A face that looks away from the sun needs no ray.
        if (seen.at.face == RX_FACE_INSIDE || dot(normal, sun) <= 0.0) break;
        next = rx_scene_ray_from_hit(seen, sun);
    }

    vec3 color = rx_sky(ray.dir, sun);
    uint instance = 0u;
    if (found) {
        RxMaterial material = rx_material_properties(seen.at.material);
        // Corners are darkened where the world's own voxels stand around.
        float openness = seen.instance == RX_NO_INSTANCE && seen.at.face != RX_FACE_INSIDE ? rx_openness(seen.at) : 0.9;
        vec3 light = 0.6 * openness * rx_ambient(normal, sun);
        if (sunlit) light += 2.3 * dot(normal, sun) * rx_sun_color(sun);
        color = material.albedo * rx_grain(seen.cell) * (light + material.emission);
        instance = seen.instance == RX_NO_INSTANCE ? 1u : seen.instance + 2u;
    }
    imageStore(outColor, pixel, vec4(rx_tone_curve(0.85 * color), 1.0));
    imageStore(outInstance, pixel, uvec4(instance));
}
