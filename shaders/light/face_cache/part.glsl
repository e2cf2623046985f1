// The part of the cache that keeps the light of a place: a cell around it, its face, or a quarter of that. Quarters have four times the
// noise of the whole, so they pay only where noise is little. Needs queue.glsl, cache.glsl and cells.glsl. `height` is the picture's.
// Faces of at least `quarters` pixels have quarters.
uint part_at(ivec3 voxel, uint face, vec2 uv, float height, float quarters) {
    if (!rx_is_on_instance(face) && pixels_across(voxel, face, height) >= max(quarters * max(16.0 * queue.noise, 1.0), 2.0 * fit.grain)) return rx_face_quarter(uv);
    return cell_part(voxel, face, cell_width(voxel, face, height), fit.grain);
}
