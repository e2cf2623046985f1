// Texel by texel.
#version 460
layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba16f) uniform readonly image2D image;
layout(rgba8) uniform writeonly image2D outColor;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, imageSize(outColor)))) return;
    imageStore(outColor, pixel, imageLoad(image, pixel));
}
