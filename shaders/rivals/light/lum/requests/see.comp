// Finds each pixel's first hit, in the world or in the copies of its blocks with models drawn in.
#version 460
#include <raxel/world.glsl>
#include "light/scene.glsl"
#define SCALE 1.0
#include "../field.glsl"
#include "../trace.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba32i) uniform writeonly iimage2D outHit;
layout(rgba32f) uniform writeonly image2D outPlace;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), size = imageSize(outHit);
    if (any(greaterThanEqual(pixel, size))) return;
    RxHit hit;
    bool found = lum_trace(rx_ray(frame.camera_cell, frame.camera_frac, pixel_direction(pixel, size)), hit);
    imageStore(outHit, pixel, found ? ivec4(hit.voxel, pack_hit(hit.material, hit.face)) : ivec4(0, 0, 0, -1));
    imageStore(outPlace, pixel, found ? vec4(hit.uv, hit.t, 0.0) : vec4(0.0));
}
