// The block that graphs/light/base/light.toml fills for every pass of a lighting system.
#ifndef LIGHT_FRAME_GLSL
#define LIGHT_FRAME_GLSL

#include <raxel/camera.glsl>
#include <raxel/light/environment.glsl>

layout(std140) uniform Frame {
    mat4 view_to_world;
    ivec3 camera_cell;
    uint index;
    vec3 camera_frac;
    uint still;  // frames since anything but the time changed
    vec2 tan_half_fov;
    float sun_azimuth;
    float sun_elevation;
    float sun_strength;
    float sky_strength;
    float lamp_strength;
    uint seed;
} frame;

// The direction to the sun, also below the horizon.
vec3 frame_true_sun() {
    return rx_sun_direction(frame.sun_azimuth, frame.sun_elevation);
}

#ifndef SKY_TABLE
// The direction to the light of the sky that throws shadows.
vec3 frame_sun() {
    return frame_true_sun();
}
#endif

#endif
