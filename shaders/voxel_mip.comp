// Makes one mip of a world as a 3-D image (layout `texture3d`) from the next finer one, after rx_set has written mip 0. A texel is 0 if all
// texels of its cube are 0, else it is one of their materials. Dispatch once for each mip, from mip 1 on, with a thread for each texel.
#version 460

layout(local_size_x = 4, local_size_y = 4, local_size_z = 4) in;
layout(r16ui) uniform readonly uimage3D fine;
layout(r16ui) uniform writeonly uimage3D coarse;

void main() {
    ivec3 texel = ivec3(gl_GlobalInvocationID);
    ivec3 size = imageSize(coarse), fine_size = imageSize(fine);
    if (any(greaterThanEqual(texel, size))) return;

    // A mip of odd size has a texel more than twice the next one's. That texel goes into the last coarse one. Otherwise the mips above
    // would lose it, although their cubes hold it.
    ivec3 first = 2 * texel;
    ivec3 end = mix(first + 2, fine_size, equal(texel, size - 1));
    uint material = 0u;
    for (int z = first.z; z < end.z && material == 0u; ++z) {
        for (int y = first.y; y < end.y && material == 0u; ++y) {
            for (int x = first.x; x < end.x && material == 0u; ++x) material = imageLoad(fine, ivec3(x, y, z)).x;
        }
    }
    imageStore(coarse, texel, uvec4(material));
}
