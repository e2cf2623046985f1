// The first hit of each pixel.
#version 460
#include <raxel/scene.glsl>
#include "scene.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba32i) uniform writeonly iimage2D outHit;    // voxel; material and face in one word, -1 for the sky
layout(rgba32f) uniform writeonly image2D outPlace;   // place on the face, distance

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), size = imageSize(outHit);
    if (any(greaterThanEqual(pixel, size))) return;
    RxHit hit;
    bool found = rx_trace_places(rx_scene_ray(rx_ray(frame.camera_cell, frame.camera_frac, pixel_direction(pixel, size))), hit);
    imageStore(outHit, pixel, found ? ivec4(hit.voxel, pack_hit(hit.material, hit.face)) : ivec4(0, 0, 0, -1));
    imageStore(outPlace, pixel, found ? vec4(hit.uv, hit.t, 0.0) : vec4(0.0));
}
