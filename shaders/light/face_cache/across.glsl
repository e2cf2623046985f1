// Pixels across a face, from the distance between its middle and the camera, so that all of its pixels agree. `height` is that of the picture.
float pixels_across(ivec3 voxel, uint face, float height) {
    vec3 middle = vec3(voxel - frame.camera_cell) - frame.camera_frac + 0.5 + 0.5 * rx_normal(face);
    return 0.5 * height / (frame.tan_half_fov.y * max(length(middle), 1e-3));
}
