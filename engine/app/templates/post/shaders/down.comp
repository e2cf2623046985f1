// A mip from the finer one: the mean of four texels.
#version 460
layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba16f) uniform readonly image2D fine;
layout(rgba16f) uniform writeonly image2D coarse;

void main() {
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(texel, imageSize(coarse)))) return;

    vec4 sum = vec4(0.0);
    for (int i = 0; i < 4; ++i) {
        ivec2 from = min(2 * texel + ivec2(i & 1, i >> 1), imageSize(fine) - 1);
        sum += imageLoad(fine, from);
    }
    imageStore(coarse, texel, 0.25 * sum);
}
