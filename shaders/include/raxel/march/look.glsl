// rx_look (see trace.glsl) for the layouts whose tracers do without it, so that marchers go over them too.
#ifndef RAXEL_MARCH_LOOK_GLSL
#define RAXEL_MARCH_LOOK_GLSL

#ifndef RAXEL_TRACE_GLSL
#if defined(RX_LAYOUT_TREE64)

uint rx_look(ivec3 cell, out uint log2_free) {
    uvec3 c = uvec3(cell) - uvec3(world.origin);
    uvec4 node = world.quads[world.root];
    log2_free = 0u;
    for (uint height = world.log2_size >> 1;; --height) {
        uint child = rx_child(c, height);
        if (!rx_has_child(node.xy, child)) {
            log2_free = 2u * height - 2u + (rx_free_octet(node.xy, child) ? 1u : 0u);
            return 0u;
        }
        if ((node.w & RX_FILLED) != 0u) return node.w & 0xffffu;
        uint rank = rx_child_rank(node.xy, child);
        if (height == 2u) {
            uvec2 leaf = rx_leaf(node.z + rank);
            uint voxel = rx_child(c, 1u);
            if (rx_has_child(leaf, voxel)) return rx_leaf_material(node.w, rank, leaf, voxel);
            log2_free = rx_free_octet(leaf, voxel) ? 1u : 0u;
            return 0u;
        }
        node = world.quads[node.z + rank];
    }
}

#else

// Knows of nothing but the voxel.
uint rx_look(ivec3 cell, out uint log2_free) {
    log2_free = 0u;
    return rx_material(cell);
}

#endif
#endif

#endif
