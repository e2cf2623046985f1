// The mean of the air over all frames that have stood still.
#version 460
#include "light/frame.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
uniform sampler3D air;
layout(rgba32f) uniform image2D mean;

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(at, imageSize(mean)))) return;
    vec4 now = texelFetch(air, ivec3(at.x % 40, at.y, at.x / 40), 0), before = imageLoad(mean, at);
    imageStore(mean, at, before + (now - before) / float(frame.still + 1u));
}
