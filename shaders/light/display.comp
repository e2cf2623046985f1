// Linear light becomes a picture.
#version 460
#include <raxel/tone.glsl>

layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba32f) uniform readonly image2D radiance;
layout(rgba16f) uniform writeonly image2D outColor;
layout(push_constant) uniform Push { float exposure; } push;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, imageSize(outColor)))) return;
    imageStore(outColor, pixel, vec4(rx_tone_narkowicz(push.exposure * imageLoad(radiance, pixel).rgb), 1.0));
}
