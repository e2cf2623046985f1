// From the camera to the centre of a face.
vec3 face_middle(ivec3 voxel, uint face) {
#ifdef RX_BINDS_instances
    if (rx_is_on_instance(face)) {
        RxRay ray = RX_RAY(rx_ray_from_place(voxel, face, vec2(0.5), vec3(0.0)));
        return vec3(ray.cell - frame.camera_cell) + ray.frac - frame.camera_frac;
    }
#endif
    return vec3(voxel - frame.camera_cell) - frame.camera_frac + 0.5 + 0.5 * rx_normal(face);
}

// Pixels across a voxel there. `height` is that of the picture.
float pixels_from(vec3 middle, float height) {
    return 0.5 * height / (frame.tan_half_fov.y * max(length(middle), 1e-3));
}

// Pixels across a face, from the distance between its centre and the camera, so that all of its pixels agree.
float pixels_across(ivec3 voxel, uint face, float height) {
    return pixels_from(face_middle(voxel, face), height);
}
