// The first voxel along each pixel's ray, where that may be another one than in the frame before.
#version 460
#include <raxel/world.glsl>
#include <raxel/box.glsl>
#include <raxel/camera.glsl>
#include <raxel/shade.glsl>
#include "changed.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba16f) uniform image2D color;
layout(r32ui) uniform writeonly uimage2D outMade;
layout(std430) readonly buffer View { Camera view; };
layout(std430) buffer Count { uint made; };

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    ivec2 size = imageSize(color);
    if (any(greaterThanEqual(pixel, size))) return;

    RxRay ray = rx_camera_ray(frame.camera_cell, frame.camera_frac, frame.view_to_world, frame.tan_half_fov, pixel, size);
    // Corners are darkened by voxels up to two away from the ray. A target that was never written has no alpha.
    bool shown = view.moved == 0u && imageLoad(color, pixel).a != 0.0;
    if (shown && !rx_crosses_box(ray, frame.changed_min, frame.changed_max, 2)) {
        imageStore(outMade, pixel, uvec4(0u));
        return;
    }

    vec3 sun = rx_sun_direction(215.0, 40.0);
    RxHit hit;
    vec3 seen = rx_sky(ray.dir, sun);
    if (rx_trace(ray, hit) && hit.face != RX_FACE_INSIDE) {
        vec3 normal = rx_normal(hit.face);
        vec3 light = 0.6 * rx_openness(hit) * rx_ambient(normal, sun) + 1.5 * max(dot(normal, sun), 0.0) * rx_sun_color(sun);
        seen = rx_material_properties(hit.material).albedo * light;
    }
    imageStore(color, pixel, vec4(rx_tone_curve(seen), 1.0));
    imageStore(outMade, pixel, uvec4(1u));
    atomicAdd(made, 1u);
}
