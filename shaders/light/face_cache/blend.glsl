// Light between the middles of neighbouring faces of one plane. Only faces that are seen in this frame take part, so each of them is bare;
// two bare faces side by side have no wall between them, and across a corner the light goes by one of the two faces beside it. So
// nothing leaks.

// The slot of the part of a face that lies `step` parts further on its plane, if it is seen in this frame.
uint seen_beside(ivec3 voxel, uint face, uint part, ivec2 step) {
    ivec3 u, v;
    rx_face_tangents(face, u, v);
    ivec2 place = part == 0u ? step : ivec2(part - 1u & 1u, part - 1u >> 1) + step;
    ivec2 whole = part == 0u ? place : place >> 1;
    uint there = part == 0u ? 0u : 1u + uint(place.x & 1) + 2u * uint(place.y & 1);
    ivec3 other = voxel + whole.x * u + whole.y * v;
    if (!rx_face_fits(other, world.origin)) return RX_NO_FACE;
    uint slot = rx_face_find(rx_face_key(other, face, there, world.origin));
    return slot != RX_NO_FACE && asked[slot] == frame.index + 1u ? slot : RX_NO_FACE;
}

vec3 blended(uint slot, vec2 uv, vec3 own) {
    RxFaceKey key;
    ivec3 voxel;
    uint face, part;
    if (!rx_face_in_slot(slot, key)) return own;
    rx_face_of(key, world.origin, voxel, face, part);
    vec3 corner = rx_face_part(part);
    vec2 from_middle = (uv - corner.xy) / corner.z - 0.5;
    ivec2 step = ivec2(from_middle.x < 0.0 ? -1 : 1, from_middle.y < 0.0 ? -1 : 1);
    vec2 share = abs(from_middle);

    uint along = seen_beside(voxel, face, part, ivec2(step.x, 0)), across = seen_beside(voxel, face, part, ivec2(0, step.y));
    vec3 a = along == RX_NO_FACE ? own : light[along].rgb;
    vec3 b = across == RX_NO_FACE ? own : light[across].rgb;
    vec3 c = 0.5 * (a + b);
    if (along != RX_NO_FACE || across != RX_NO_FACE) {
        uint diagonal = seen_beside(voxel, face, part, step);
        if (diagonal != RX_NO_FACE) c = light[diagonal].rgb;
    }
    return mix(mix(own, a, share.x), mix(b, c, share.x), share.y);
}
