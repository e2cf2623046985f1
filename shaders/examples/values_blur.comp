// A blur with the weights of the graph's table, along both axes at once.
#version 460

layout(local_size_x = 8, local_size_y = 8) in;
layout(constant_id = 0) const uint TAPS = 1;
layout(std430) readonly buffer Kernel { float kernel[]; };
layout(rgba16f) uniform readonly image2D sharp;
layout(rgba16f) uniform writeonly image2D outColor;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    ivec2 size = imageSize(outColor);
    if (any(greaterThanEqual(pixel, size))) return;
    int reach = int(TAPS) / 2;
    vec3 sum = vec3(0.0);
    for (int y = 0; y < int(TAPS); ++y) {
        for (int x = 0; x < int(TAPS); ++x) {
            ivec2 at = clamp(pixel + ivec2(x, y) - reach, ivec2(0), size - 1);
            sum += kernel[x] * kernel[y] * imageLoad(sharp, at).rgb;
        }
    }
    imageStore(outColor, pixel, vec4(sum, 1.0));
}
