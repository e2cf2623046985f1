// Rays of pixels that begin where nothing can be hit before.

RxRay ray_of(ivec2 pixel, ivec2 size) {
    return rx_ray(frame.camera_cell, frame.camera_frac, pixel_direction(pixel, size));
}

// Stores the hit of a pixel's ray, which is known to pass `free` voxels along its steepest axis freely.
void trace_behind(ivec2 pixel, RxRay ray, float free) {
    RxHit hit;
    bool found = free < RX_BUNDLE_EMPTY && rx_trace_from(ray, rx_bundle_time(ray, free), hit);
    imageStore(outHit, pixel, found ? ivec4(hit.voxel, pack_hit(hit.material, hit.face)) : ivec4(0, 0, 0, -1));
    imageStore(outPlace, pixel, found ? vec4(hit.uv, hit.t, 0.0) : vec4(0.0));
}
