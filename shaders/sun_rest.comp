// Finds whether the sun reaches the hits of the pixels in the queue, ray by ray.
#version 460
#include <raxel/world.glsl>
#include "sun_ray.glsl"

layout(local_size_x = 64) in;
layout(std430) readonly buffer RestCount { uint groups[3]; uint count; } restCount;
layout(std430) readonly buffer Rest { uvec2 entries[]; } rest;

void main() {
    uint lane = gl_LocalInvocationIndex & 31u;
    // Two entries a workgroup; there may be more entries than one row of workgroups has room for.
    for (uint i = 2u * gl_WorkGroupID.x + (gl_LocalInvocationIndex >> 5); i < restCount.count; i += 2u * gl_NumWorkGroups.x) {
        uvec2 entry = rest.entries[i];
        ivec2 pixel = ivec2(entry.x & 0xffffu, entry.x >> 16) + ivec2(lane & 7u, lane >> 3);
        if (((entry.y >> lane) & 1u) == 0u || any(greaterThanEqual(pixel, imageSize(outSun)))) continue;
        RxRay ray;
        RxHit hit;
        bool seen = sun_ray(pixel, sun_direction(), ray) && !rx_trace(ray, hit);
        imageStore(outSun, pixel, uvec4(seen ? 1u : 0u));
    }
}
