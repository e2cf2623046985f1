// Leaves the rays of all pixels to see.comp.
#version 460
#include "first.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(rg32ui) uniform writeonly uimage2D outFirst;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (all(lessThan(pixel, imageSize(outFirst)))) imageStore(outFirst, pixel, uvec4(first_rest(0.0), 0u, 0u));
}
