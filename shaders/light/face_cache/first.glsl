// The first hit of a pixel in the world, in two words: the face, and the voxel from the corner of the world's cube. The cube of a known hit is
// at most 4096 voxels wide. Or the pixel sees nothing, or its ray must be traced from a time on.
const uint FIRST_REST = 0u, FIRST_MISS = 1u, FIRST_HIT = 2u;   // and the face

uvec2 first_hit(uvec3 from_corner, uint face) {
    return uvec2(from_corner.x | from_corner.y << 16, from_corner.z | FIRST_HIT + face << 16);
}

uvec2 first_miss() {
    return uvec2(0u, FIRST_MISS << 16);
}

uvec2 first_rest(float t_free) {
    return uvec2(floatBitsToUint(t_free), FIRST_REST << 16);
}
