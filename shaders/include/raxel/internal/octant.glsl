// Children of octree nodes, for the layouts that have them: child x + 2y + 4z of each node, and masks with a bit for each child.
#ifndef RAXEL_OCTANT_GLSL
#define RAXEL_OCTANT_GLSL

// The child that holds `c`, of a node of 2^height voxels a side.
uint rx_octant(uvec3 c, uint height) {
    uvec3 child = (c >> (height - 1u)) & 1u;
    return child.x | (child.y << 1) | (child.z << 2);
}

// Occupied children in front of a child, by the low eight bits of `node`.
uint rx_octant_rank(uint node, uint child) {
    return uint(bitCount(node & ((1u << child) - 1u)));
}

#endif
