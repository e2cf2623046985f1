// The surface of each pixel: its colour, the way it faces, and how far away it is.
#version 460
#include <raxel/world.glsl>
#include <raxel/camera.glsl>
#include "frame.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba8) uniform writeonly image2D outAlbedo;        // alpha is 0 for the sky
layout(rgba8_snorm) uniform writeonly image2D outNormal;
layout(r32f) uniform writeonly image2D outDepth;          // voxels

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    ivec2 size = imageSize(outAlbedo);
    if (any(greaterThanEqual(pixel, size))) return;

    RxRay ray = rx_camera_ray(frame.camera_cell, frame.camera_frac, frame.view_to_world, frame.tan_half_fov, pixel, size);
    RxHit hit;
    bool found = rx_trace(ray, hit);
    imageStore(outAlbedo, pixel, found ? vec4(rx_material_properties(hit.material).albedo, 1.0) : vec4(0.0));
    imageStore(outNormal, pixel, vec4(found ? rx_normal(hit.face) : vec3(0.0), 0.0));
    imageStore(outDepth, pixel, vec4(found ? hit.t : 0.0));
}
