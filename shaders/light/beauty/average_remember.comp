// Keeps the mean for the next frame, and empties the histogram for this one.
#version 460
layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba32f) uniform readonly image2D average;
layout(rgba32f) uniform writeonly image2D outBefore;
layout(std430) writeonly buffer Histogram { uint bins[256]; };

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), size = imageSize(outBefore);
    if (gl_WorkGroupID.xy == uvec2(0)) {
        for (uint i = gl_LocalInvocationIndex; i < 256u; i += 64u) bins[i] = 0u;
    }
    if (all(lessThan(pixel, size))) imageStore(outBefore, pixel, imageLoad(average, pixel));
}
