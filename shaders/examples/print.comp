// Draws the first hit of each pixel. The pixel under the cursor, or the central one, prints the result of its ray.
#version 460
#include <raxel/world.glsl>
#include <raxel/camera.glsl>
#include <raxel/print.glsl>

layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba16f) uniform writeonly image2D outColor;
layout(push_constant) uniform Push {
    mat4 view_to_world;
    ivec3 camera_cell;
    vec3 camera_frac;
    vec2 tan_half_fov;
    ivec2 cursor;         // -1 where there is none
};

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    ivec2 size = imageSize(outColor);
    if (any(greaterThanEqual(pixel, size))) return;

    RxRay ray = rx_camera_ray(camera_cell, camera_frac, view_to_world, tan_half_fov, pixel, size);
    RxHit hit;
    bool found = rx_trace(ray, hit);
    rx_assert(!found || hit.t >= 0.0);

    ivec2 chosen = cursor.x < 0 ? size / 2 : cursor;
    if (pixel == chosen) {
        if (found) debugPrintfEXT("voxel (%v3d), material %u, %.2f voxels away, %u steps", hit.voxel, hit.material, hit.t, hit.steps);
        else debugPrintfEXT("sky, %u steps", hit.steps);
    }

    vec3 color = found ? rx_material_properties(hit.material).albedo * (0.6 + 0.4 * rx_normal(hit.face).y) : vec3(0.5, 0.7, 0.9);
    bool cross = pixel.x == chosen.x || pixel.y == chosen.y;
    imageStore(outColor, pixel, vec4(cross ? vec3(1.0, 0.2, 0.1) : color, 1.0));
}
