// Rays of a pinhole camera, from the values that a graph pushes with `from = "camera.…"`.
#ifndef RAXEL_CAMERA_GLSL
#define RAXEL_CAMERA_GLSL

#include "ray.glsl"

// Direction in world space, of length 1, through a place on the output. `pixel` is in pixels from the top left; add 0.5 to an
// index for its middle.
vec3 rx_camera_direction(mat4 view_to_world, vec2 tan_half_fov, vec2 pixel, vec2 size) {
    vec2 ndc = vec2(2.0, -2.0) * (pixel / size) + vec2(-1.0, 1.0);
    return normalize(mat3(view_to_world) * vec3(ndc * tan_half_fov, -1.0));
}

// The ray through the middle of a pixel. `cell` and `frac` are camera.cell and camera.frac.
RxRay rx_camera_ray(ivec3 cell, vec3 frac, mat4 view_to_world, vec2 tan_half_fov, ivec2 pixel, ivec2 size) {
    return rx_ray(cell, frac, rx_camera_direction(view_to_world, tan_half_fov, vec2(pixel) + 0.5, vec2(size)));
}

#endif
