// How many pixels have which luminance, in 256 steps of its logarithm from 2^-12 to 2^12.
#version 460
layout(local_size_x = 16, local_size_y = 16) in;
layout(rgba32f) uniform readonly image2D average;
layout(std430) buffer Histogram { uint bins[256]; };
shared uint mine[256];

void main() {
    uint i = gl_LocalInvocationIndex;
    mine[i] = 0u;
    barrier();
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (all(lessThan(pixel, imageSize(average)))) {
        float l = dot(imageLoad(average, pixel).rgb, vec3(0.2126, 0.7152, 0.0722));
        atomicAdd(mine[uint(clamp((log2(max(l, 1e-6)) + 12.0) / 24.0 * 256.0, 0.0, 255.0))], 1u);
    }
    barrier();
    if (mine[i] > 0u) atomicAdd(bins[i], mine[i]);
}
