// Sun and sky as light: the same for every system that is compared with the reference.
#ifndef RAXEL_LIGHT_ENVIRONMENT_GLSL
#define RAXEL_LIGHT_ENVIRONMENT_GLSL

#include "../sky.glsl"
#include "sampling.glsl"

// 1 - cos(0.267 degrees): the height of the cap that the sun's disc covers on the unit sphere.
const float RX_SUN_CAP = 1.0857916e-5;

// Radiance of the sky. The disc of the sun is not in it: a pixel that shows the disc would outweigh all others.
vec3 rx_sky_light(vec3 dir, vec3 sun, float strength) {
    return strength * rx_sky(dir, sun);
}

// Irradiance of the whole disc of the sun on a plane that faces it.
vec3 rx_sun_light(vec3 sun, float strength) {
    return strength * RX_PI * rx_sun_color(sun);
}

// A direction to a point of the sun's disc, even over the disc.
vec3 rx_sun_point(vec3 sun, vec2 u) {
    return rx_cone_direction(sun, RX_SUN_CAP, u);
}

#endif
