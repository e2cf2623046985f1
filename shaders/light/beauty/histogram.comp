// Counts places of the picture by luminance, in 256 steps of its logarithm from 2^-16 to 2^12. Places are texels of the finest mip of the bloom:
// a quarter of the pixels, each a mean of its neighbours. So a speck of noise weighs as little as it does to the eye.
#version 460
layout(local_size_x = 16, local_size_y = 16) in;
layout(rgba16f) uniform readonly image2D picture;
layout(std430) buffer Histogram { uint bins[256]; };
shared uint mine[256];

void main() {
    uint i = gl_LocalInvocationIndex;
    mine[i] = 0u;
    barrier();
    ivec2 place = ivec2(gl_GlobalInvocationID.xy);
    if (all(lessThan(place, imageSize(picture)))) {
        float l = dot(imageLoad(picture, place).rgb, vec3(0.2126, 0.7152, 0.0722));
        atomicAdd(mine[uint(clamp((log2(max(l, 1e-6)) + 16.0) / 28.0 * 256.0, 0.0, 255.0))], 1u);
    }
    barrier();
    if (mine[i] > 0u) atomicAdd(bins[i], mine[i]);
}
