// A quarter of the picture for each tone curve.
#version 460
#include <raxel/tone.glsl>

layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba32f) uniform readonly image2D radiance;
layout(rgba16f) uniform writeonly image2D outColor;
layout(push_constant) uniform Push { float exposure; } push;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), size = imageSize(outColor);
    if (any(greaterThanEqual(pixel, size))) return;
    uint curve = uint(4 * pixel.x / size.x);
    imageStore(outColor, pixel, vec4(rx_tone(push.exposure * imageLoad(radiance, pixel).rgb, curve), 1.0));
}
