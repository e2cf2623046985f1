// Where faces have keys (face_table.glsl): on each axis where all solid voxels are, if the box has room for them, else around the camera. Needs <raxel/world.glsl> and scene.glsl.
#ifndef FACE_CACHE_BOX_GLSL
#define FACE_CACHE_BOX_GLSL

ivec3 face_box() {
    const ivec3 sides = ivec3(16384, 4096, 16384);
    return mix(frame.camera_cell - sides / 2, world.bounds_min, lessThan(world.bounds_last - world.bounds_min, sides));
}

#endif
