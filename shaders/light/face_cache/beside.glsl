// The key of the part of a face that lies `step` parts further on its plane; false if it has none.
bool key_beside(ivec3 voxel, uint face, uint part, ivec2 step, out RxFaceKey key) {
    ivec3 u, v;
    rx_face_tangents(face, u, v);
    ivec2 place = part == 0u ? step : ivec2(part - 1u & 1u, part - 1u >> 1) + step;
    ivec2 whole = part == 0u ? place : place >> 1;
    uint there = part == 0u ? 0u : 1u + uint(place.x & 1) + 2u * uint(place.y & 1);
    ivec3 other = voxel + whole.x * u + whole.y * v;
    key = rx_face_key(other, face, there);
    return rx_face_fits(other, face_box());
}

// Its slot, if it was seen in this frame or in the `before` frames before it.
uint seen_beside(ivec3 voxel, uint face, uint part, ivec2 step, uint before) {
    RxFaceKey key;
    if (!key_beside(voxel, face, part, step, key)) return RX_NO_FACE;
    uint slot = rx_face_find(key);
    return slot != RX_NO_FACE && frame.index + 1u - asked[slot] <= before ? slot : RX_NO_FACE;
}
