// Rays of a pinhole camera, from the values that a graph pushes with `from = "camera.…"`.
//
// A direction takes additions and multiplications only, each rounded by itself (`precise`). So every device and raxel_oracle::camera get the
// same bits, and a judge can compare ray by ray.
#ifndef RAXEL_CAMERA_GLSL
#define RAXEL_CAMERA_GLSL

#include "ray.glsl"

// 1 / sqrt(x) to about two ulp, for x in 1e-30 to 1e30: three Newton steps from the exponent's first guess.
float rx_inverse_root(float x) {
    precise float y = uintBitsToFloat(0x5f3759dfu - (floatBitsToUint(x) >> 1));
    for (int i = 0; i < 3; ++i) {
        precise float square = (0.5 * x * y) * y;
        y = y * (1.5 - square);
    }
    return y;
}

// Direction in world space, of length 1, through a place on the output. `pixel` is in pixels from the top left; add 0.5 to an index for its
// centre.
vec3 rx_camera_direction(mat4 view_to_world, vec2 tan_half_fov, vec2 pixel, vec2 size) {
    // In view space, times width and height, so that nothing is divided.
    precise vec2 from_middle = vec2(2.0, -2.0) * pixel + vec2(-size.x, size.y);
    precise vec2 view = from_middle * (tan_half_fov * size.yx);
    precise float ahead = size.x * size.y;
    precise vec3 right = view_to_world[0].xyz * view.x;
    precise vec3 up = view_to_world[1].xyz * view.y;
    precise vec3 back = view_to_world[2].xyz * ahead;
    precise vec3 sum = right + up;
    precise vec3 dir = sum - back;
    precise vec3 squares = dir * dir;
    precise float length_squared = squares.x + squares.y;
    length_squared = length_squared + squares.z;
    precise vec3 unit = dir * rx_inverse_root(length_squared);
    return unit;
}

// The ray through the centre of a pixel. `cell` and `frac` are camera.cell and camera.frac.
RxRay rx_camera_ray(ivec3 cell, vec3 frac, mat4 view_to_world, vec2 tan_half_fov, ivec2 pixel, ivec2 size) {
    return rx_ray(cell, frac, rx_camera_direction(view_to_world, tan_half_fov, vec2(pixel) + 0.5, vec2(size)));
}

// The length of the way through the centre of a pixel from the camera to depth 1, which is a distance along the camera's axis.
float rx_camera_length(mat4 view_to_world, vec2 tan_half_fov, ivec2 pixel, ivec2 size) {
    vec2 place = (vec2(2 * pixel + 1) / vec2(size) - 1.0) * tan_half_fov;
    return length(view_to_world[0].xyz * place.x - view_to_world[1].xyz * place.y - view_to_world[2].xyz);
}

#endif
