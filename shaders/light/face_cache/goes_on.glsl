// Whether the view continues from the last frame, so that the faces seen then predict those seen now. Needs cache.glsl and
// ../frame.glsl.
bool fit_goes_on(uint pixels) {
    const float FARTHEST = 8.0, TURN = 0.98, ZOOM = 0.1;   // voxels, cosine, a part of the field of view
    vec3 moved = vec3(frame.camera_cell - fit.cell) + frame.camera_frac - fit.frac;
    return pixels == fit.pixels && dot(moved, moved) < FARTHEST * FARTHEST && dot(frame.view_to_world[2].xyz, fit.forward) > TURN
        && abs(frame.tan_half_fov.y - fit.tangent) < ZOOM * fit.tangent;
}
