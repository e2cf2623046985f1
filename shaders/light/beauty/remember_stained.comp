// Keeps sunlight that came through panes for the next frame.
#version 460
layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba32f) uniform readonly image2D stained;
layout(rgba32f) uniform writeonly image2D outBefore;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (all(lessThan(pixel, imageSize(outBefore)))) imageStore(outBefore, pixel, imageLoad(stained, pixel));
}
