// The part of a face that keeps the light of a place on it: the whole face, or its quarter where the face is wide. Quarters have four times
// the noise of the whole, and pay where that is little. Needs queue.glsl and across.glsl; `height` is that of the picture, `quarters` the
// width in pixels from which on there are quarters.
uint part_at(ivec3 voxel, uint face, vec2 uv, float height, float quarters) {
    return pixels_across(voxel, face, height) < quarters * max(16.0 * queue.noise, 1.0) ? 0u : rx_face_quarter(uv);
}
