// A place's position on the picture of the frame before.
#ifndef RAXEL_LIGHT_REPROJECT_GLSL
#define RAXEL_LIGHT_REPROJECT_GLSL

// `from_camera` leads from the earlier camera to the place, in world space. Build it from whole cells and fractions apart, so that it is
// exact far from the origin:
//
//     vec3(camera.cell - camera.previous.cell) + (camera.frac - camera.previous.frac) + distance * direction
//
// `world_to_view` is the rotation in camera.previous.world_to_view. `at` is in pixels from the top left; false if the place was behind
// the camera or outside the picture.
bool rx_reproject(vec3 from_camera, mat3 world_to_view, vec2 tan_half_fov, vec2 size, out vec2 at) {
    vec3 view = world_to_view * from_camera;
    at = vec2(-1.0);
    if (!(view.z < 0.0)) return false;
    at = (vec2(view.x, -view.y) / (-view.z * tan_half_fov) * 0.5 + 0.5) * size;
    return all(greaterThanEqual(at, vec2(0.0))) && all(lessThan(at, size));
}

#endif
