// A world as a pyramid of cubes of 2^level voxels a side, aligned from world.origin, down to the voxels at level 0.
#ifndef RAXEL_MARCH_PYRAMID_GLSL
#define RAXEL_MARCH_PYRAMID_GLSL

#include "line.glsl"

#if !defined(RX_LAYOUT_OCTREE) && !defined(RX_LAYOUT_TEXTURE3D)
// Whether the cube of 2^level voxels that holds `cell` may have a solid voxel; at level 0, whether it is one. Layouts that keep a pyramid
// answer by themselves. For the others, it follows from the free space around the cell.
bool rx_occupied(ivec3 cell, uint level) {
    uint log2_free;
    return rx_look(cell, log2_free) != 0u || log2_free < level;
}
#endif

#endif
