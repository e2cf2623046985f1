#version 460
layout(local_size_x = 8, local_size_y = 8) in;
layout(r16f) uniform readonly image2D above;
layout(r16f) uniform writeonly image2D below;
uniform sampler2D depth;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    imageStore(below, pixel, imageLoad(above, pixel * 2) + texelFetch(depth, pixel * 4, 0));
}
