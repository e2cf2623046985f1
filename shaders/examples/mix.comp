// Mixes a picture with the one before, if there is one.
#version 460
layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba16f) uniform readonly image2D now;
layout(rgba16f) uniform readonly image2D before;
layout(rgba16f) uniform writeonly image2D outMixed;
layout(push_constant) uniform Push {
    float delay;  // 0 to 1: the part of the picture before
    uint valid;
} push;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, imageSize(outMixed)))) return;
    vec4 color = imageLoad(now, pixel);
    if (push.valid != 0u) color = mix(color, imageLoad(before, pixel), push.delay);
    imageStore(outMixed, pixel, color);
}
