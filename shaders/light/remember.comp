// Keeps this frame's results for the next one. Not `history`, which turns with every frame, also when the passes rest.
#version 460
layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba32i) uniform readonly iimage2D hits;
layout(rg32f) uniform readonly image2D sun;
layout(rgba32i) uniform writeonly iimage2D hitsBefore;
layout(rg32f) uniform writeonly image2D sunBefore;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, imageSize(hitsBefore)))) return;
    imageStore(hitsBefore, pixel, imageLoad(hits, pixel));
    imageStore(sunBefore, pixel, imageLoad(sun, pixel));
}
