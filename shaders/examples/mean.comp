// The mean of samples that were added up: their number is the fourth channel.
#version 460
layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba32f) uniform readonly image2D sum;
layout(rgba16f) uniform writeonly image2D outColor;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, imageSize(outColor)))) return;
    vec4 all = imageLoad(sum, pixel);
    imageStore(outColor, pixel, vec4(all.rgb / max(all.a, 1.0), 1.0));
}
