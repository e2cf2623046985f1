// Layout `texture3d`: a 3-D image of the voxels, whose mips are an octree. Texel c of mip k is 0 if the cube of 2^k voxels at c * 2^k is empty,
// otherwise a material. The buffer `world` has the header and the materials only; a pass binds both,
//
//     bind = { world = "world", world_voxels = "voxels" }
//
// where the target `voxels` and the buffer `world` have the source "world.texture3d". Dense: for small worlds. rx_set writes the image
// as `world_texels = { target = "voxels", mip = 0 }`.
layout(std430) readonly buffer RxWorld {
#include <raxel/internal/header.glsl>
    ivec3 size;           // texels of mip 0, multiples of 64
    uint mip_count;       // down to one texel
    uint words[];
} world;

uniform usampler3D world_voxels;

#include <raxel/internal/material.glsl>

// Whether the cube of 2^mip voxels that holds cell c has a texel, and it is empty.
bool rx_mip_free(uvec3 c, uint mip) {
    uvec3 texel = c >> mip;
    // Far ends that do not fill a cube have no texel.
    if (any(greaterThanEqual(texel, max(uvec3(world.size) >> mip, uvec3(1u))))) return false;
    return texelFetch(world_voxels, ivec3(texel), int(mip)).x == 0u;
}

uint rx_look(ivec3 cell, out uint log2_free) {
    uvec3 c = uvec3(cell) - uvec3(world.origin);
    log2_free = 0u;
    if (any(greaterThanEqual(c, uvec3(world.size)))) {
        // Beyond the image, in cubes of 64 or more that do not reach into it.
        for (log2_free = 6u; log2_free + 1u < world.log2_size; ++log2_free) {
            uint next = log2_free + 1u;
            if (!any(greaterThanEqual((c >> next) << next, uvec3(world.size)))) break;
        }
        return 0u;
    }
    uint material = texelFetch(world_voxels, ivec3(c), 0).x;
    if (material != 0u) return material;
    // The largest empty mip; those below it are empty too.
    uint high = world.mip_count - 1u;
    while (log2_free < high) {
        uint middle = high - ((high - log2_free) >> 1);
        if (rx_mip_free(c, middle)) log2_free = middle;
        else high = middle - 1u;
    }
    return 0u;
}

// Whether the cube of 2^level voxels around a cell may have a solid voxel, for rivals/march/pyramid.glsl: one texel of its mip answers
// that.
bool rx_occupied(ivec3 cell, uint level) {
    uvec3 c = uvec3(cell) - uvec3(world.origin);
    if (any(greaterThanEqual(c, uvec3(world.size)))) {
        uint log2_free;
        rx_look(cell, log2_free);
        return log2_free < level;
    }
    return level >= world.mip_count || !rx_mip_free(c, level);
}

#include <raxel/internal/trace.glsl>

#ifdef RX_WRITE
layout(r16ui) uniform uimage3D world_texels;

// A voxel of mip 0. shaders/voxel_mip.comp must fill the mips again before rays are traced.
bool rx_set(ivec3 cell, uint material) {
    uvec3 c = uvec3(cell) - uvec3(world.origin);
    if (any(greaterThanEqual(c, uvec3(world.size)))) return false;
    imageStore(world_texels, ivec3(c), uvec4(material & 0xffffu));
    return true;
}
#endif
