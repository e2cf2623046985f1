// The mean of all frames at rest.
#version 460
#include "light/scene.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(std430) readonly buffer Light { vec4 light[]; };
layout(rgba32f) uniform image2D sum;
layout(rgba32f) uniform writeonly image2D outRadiance;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), size = imageSize(sum);
    if (any(greaterThanEqual(pixel, size))) return;
    vec4 all = vec4(light[pixel.x + size.x * pixel.y].rgb, 1.0);
    if (frame.still > 0u) all += imageLoad(sum, pixel);
    imageStore(sum, pixel, all);
    imageStore(outRadiance, pixel, vec4(all.rgb / all.w, 1.0));
}
