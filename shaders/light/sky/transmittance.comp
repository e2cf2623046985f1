// Table of the light that comes through the air.
#version 460
#include <raxel/light/atmosphere.glsl>

layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba16f) uniform writeonly image2D outTransmittance;

void main() {
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy), size = imageSize(outTransmittance);
    if (any(greaterThanEqual(texel, size))) return;
    float radius, cosine;
    rx_transmittance_at(vec2(texel) / vec2(size - 1), radius, cosine);
    imageStore(outTransmittance, texel, vec4(rx_air_transmittance(radius, cosine, 40), 1.0));
}
