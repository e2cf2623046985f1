// The light with its glow over it.
#version 460
layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba16f) uniform readonly image2D light;
layout(rgba16f) uniform readonly image2D glow;
layout(rgba16f) uniform writeonly image2D outColor;
layout(push_constant) uniform Push {
    float strength;
} push;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, imageSize(outColor)))) return;
    imageStore(outColor, pixel, imageLoad(light, pixel) + push.strength * imageLoad(glow, pixel));
}
