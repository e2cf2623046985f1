// Where faces have keys (face_table.glsl): the box of the world, or one around the camera in a world that is larger. Needs <raxel/world.glsl> and scene.glsl.
#ifndef FACE_CACHE_BOX_GLSL
#define FACE_CACHE_BOX_GLSL

ivec3 face_box() {
    return world.log2_size <= 14u ? world.origin : frame.camera_cell - ivec3(8192, 2048, 8192);
}

#endif
