// Whether the sun is visible from each pixel's first hit, ray by ray.
#version 460
#include <raxel/world.glsl>
#include "../sun_ray.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, imageSize(outSun)))) return;
    RxRay ray;
    RxHit hit;
    bool seen = sun_ray(pixel, sun_direction(), ray) && !rx_trace(ray, hit);
    imageStore(outSun, pixel, uvec4(seen ? 1u : 0u));
}
