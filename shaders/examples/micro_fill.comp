// A ball whose inside is a gyroid, a surface that parts space in two.
#version 460
#include <raxel/micro.glsl>

layout(local_size_x = 4, local_size_y = 4, local_size_z = 4) in;
layout(rg32ui) uniform writeonly uimage3D outMicro;
layout(push_constant) uniform Push { float thickness; } push;

bool solid(vec3 at) {
    vec3 p = 1.1 * at;
    float gyroid = dot(sin(p), cos(p.yzx));
    return dot(at, at) < 60.0 && abs(gyroid) < push.thickness;
}

void main() {
    ivec3 cell = ivec3(gl_GlobalInvocationID), size = imageSize(outMicro);
    if (any(greaterThanEqual(cell, size))) return;
    uvec2 bits = uvec2(0u);
    for (int i = 0; i < 64; ++i) {
        ivec3 within = ivec3(i & 3, i >> 2 & 3, i >> 4);
        vec3 at = vec3(cell) + 0.25 * (vec3(within) + 0.5) - 0.5 * vec3(size);
        uint bit = rx_micro_bit(within);
        if (solid(at)) bits[bit >> 5] |= 1u << (bit & 31u);
    }
    imageStore(outMicro, cell, uvec4(bits, 0u, 0u));
}
