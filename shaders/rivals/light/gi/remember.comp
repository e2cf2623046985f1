// Keeps the means for the next frame.
#version 460
layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba32f) uniform readonly image2D mean;
layout(rg32f) uniform readonly image2D moments;
layout(rgba32f) uniform writeonly image2D outMean;
layout(rg32f) uniform writeonly image2D outMoments;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, imageSize(outMean)))) return;
    imageStore(outMean, pixel, imageLoad(mean, pixel));
    imageStore(outMoments, pixel, imageLoad(moments, pixel));
}
