// The key of the cell or part of a face that lies `step` cells or parts further on its plane; false if it has none.
bool key_beside(ivec3 cell, uint face, uint part, ivec2 step, out RxFaceKey key) {
    key = RxFaceKey(0u, 0u);
    ivec3 u, v;
    rx_face_tangents(RX_FACE_PART(face), u, v);
    bool quarter = part > 0u && part < CELL_PARTS;
    ivec2 place = quarter ? ivec2(part - 1u & 1u, part - 1u >> 1) + step : step;
    ivec2 whole = quarter ? place >> 1 : place;
    uint there = quarter ? 1u + uint(place.x & 1) + 2u * uint(place.y & 1) : part;
    ivec3 other = cell + whole.x * u + whole.y * v;
#ifdef RX_BINDS_instances
    if (rx_is_on_instance(face) && !instance_cell_beside(cell, whole.x * u + whole.y * v, other)) return false;
#endif
    key = cell_key(other, face, there);
    return cell_fits(other, face, there);
}

// Its slot, if it was seen in this frame or in the `before` frames before it.
uint seen_beside(ivec3 cell, uint face, uint part, ivec2 step, uint before) {
    RxFaceKey key;
    if (!key_beside(cell, face, part, step, key)) return RX_NO_FACE;
    uint slot = rx_face_find(key);
    return slot != RX_NO_FACE && frame.index + 1u - asked[slot] <= before ? slot : RX_NO_FACE;
}
