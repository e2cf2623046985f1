// The box of faces with keys (face_table.glsl). On each axis it holds all solid voxels if they fit, or lies around the camera. Needs <raxel/world.glsl> and scene.glsl.
#ifndef FACE_CACHE_BOX_GLSL
#define FACE_CACHE_BOX_GLSL

// The same for cells of 2^`log2_width` voxels, counted in cells.
ivec3 face_box(uint log2_width) {
    const ivec3 sides = ivec3(16384, 4096, 16384);
    int shift = int(log2_width);
    ivec3 first = world.bounds_min >> shift, last = world.bounds_last >> shift;
    return mix((frame.camera_cell >> shift) - sides / 2, first, lessThan(last - first, sides));
}

ivec3 face_box() {
    return face_box(0u);
}

#endif
