// The voxel's face that a place on a lamp lies on, and the place there. Needs <raxel/light/lights.glsl>.
void lamp_voxel(RxLight lamp, inout vec2 uv, out ivec3 voxel) {
    ivec3 u, v;
    rx_face_tangents(lamp.face, u, v);
    vec2 whole = min(floor(uv * lamp.edge), lamp.edge - 1.0);
    uv = uv * lamp.edge - whole;
    voxel = lamp.voxel + int(whole.x) * u + int(whole.y) * v;
    // A large face lies on the far side of its cell.
    if ((lamp.face & 1u) != 0u) voxel += (int(lamp.edge) - 1) * rx_face_step(lamp.face);
}
