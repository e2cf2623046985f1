// The water as micro-voxels: one is water where the density at its middle, between those of the cubes around, is above one half.
#version 460
#include <raxel/micro.glsl>

layout(local_size_x = 4, local_size_y = 4, local_size_z = 4) in;
uniform usampler3D walls;
uniform sampler3D field;
layout(rg32ui) uniform writeonly uimage3D outMicro;

void main() {
    ivec3 voxel = ivec3(gl_GlobalInvocationID), size = imageSize(outMicro);
    if (any(greaterThanEqual(voxel, size))) return;
    uvec2 bits = uvec2(0u);
    for (int i = 0; i < 64 && texelFetch(walls, voxel, 0).x == 0u; ++i) {
        ivec3 within = ivec3(i & 3, i >> 2 & 3, i >> 4);
        float density = textureLod(field, (vec3(voxel) + (vec3(within) + 0.5) / 4.0) / vec3(size), 0.0).x;
        uint bit = rx_micro_bit(within);
        if (density > 0.5) bits[bit >> 5] |= 1u << (bit & 31u);
    }
    imageStore(outMicro, voxel, uvec4(bits, 0u, 0u));
}
