// The cells of the hash cache: cubes of 2^level voxels, apart for each of the six directions that a face can look in. Their keys are those of
// raxel/light/face_table.glsl, with the level as the part, so that no two cells share one. Needs scene.glsl.
#include <raxel/light/face_table.glsl>

const uint CELL_LEVELS = 8u;  // the room of a key

// The level whose cells are as wide as `pixels` pixels at least, seen from the camera.
uint cell_level(ivec3 voxel, float pixels, float height) {
    float away = length(vec3(voxel - frame.camera_cell) - frame.camera_frac + 0.5);
    float width = pixels * away * 2.0 * frame.tan_half_fov.y / height;
    return uint(clamp(ceil(log2(max(width, 1e-6))), 0.0, float(CELL_LEVELS - 1u)));
}

bool cell_fits(ivec3 voxel, uint face, uint level) {
    return face != RX_FACE_INSIDE && rx_face_fits(world.origin + (voxel - world.origin >> level), world.origin);
}

RxFaceKey cell_key(ivec3 voxel, uint face, uint level) {
    return rx_face_key(world.origin + (voxel - world.origin >> level), face, level);
}
