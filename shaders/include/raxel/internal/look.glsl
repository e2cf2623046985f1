// rx_look (see trace.glsl) for the layouts that do without it, so that marchers go over them too.
#ifndef RAXEL_MARCH_LOOK_GLSL
#define RAXEL_MARCH_LOOK_GLSL

#ifdef RX_LAYOUT_BVH

// Knows only the voxel.
uint rx_look(ivec3 cell, out uint log2_free) {
    log2_free = 0u;
    return rx_material(cell);
}

#endif

#endif
