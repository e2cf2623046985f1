// The light of a system's scene: the sun and the sky of frame.glsl, equal for all compared systems. If a graph defines SKY_TABLE and binds the
// tables of base/scene.toml, it is a physical sky.
#ifndef LIGHT_SCENE_GLSL
#define LIGHT_SCENE_GLSL

#include "frame.glsl"
#include <raxel/light/sampler.glsl>

// <raxel/scene.glsl> has other bits where instances are bound.
#ifndef RX_FACE_MASK
#define RX_FACE_MASK 7u
#endif

#ifdef SKY_TABLE
#include <raxel/light/atmosphere.glsl>
uniform sampler2D sky_view;
// The distant light of the scene (sky/sky_view.comp). Without a night, without clouds, all but the first is 0.
layout(std140) uniform SunLight {
    vec4 sun_light;    // irradiance through the air, for a strength of 1: of the sun, by night of the moon
    vec4 sky_way;      // direction to it
    vec4 sky_moon;     // direction to the moon; how much of the night has come
    vec4 sky_night;    // radiance that the night adds to the sky, at the zenith; lit share of the moon
    vec4 sky_clouds;   // share of the sky that they cover, height of their base, thickness, in voxels
};

// The direction to the light of the sky that throws shadows: the sun or the moon.
vec3 frame_sun() {
    return sky_way.xyz == vec3(0.0) ? frame_true_sun() : sky_way.xyz;
}

// Irradiance on a plane that faces the sun, or by night the moon, above the clouds.
vec3 sun_irradiance(vec3 sun) {
    return frame.sun_strength * sun_light.rgb;
}

// Radiance from a direction, without the discs of sun and moon, stars and clouds. The table turns with the true sun.
vec3 sky_radiance(vec3 dir, vec3 sun) {
    return frame.sky_strength * (textureLod(sky_view, rx_sky_view_place(dir, frame_true_sun()), 0.0).rgb + sky_night.rgb * (1.9 - 0.9 * max(dir.y, 0.0)));
}

#include "sky/clouds.glsl"
#else
vec3 sun_irradiance(vec3 sun) {
    return rx_sun_light(sun, frame.sun_strength);
}

vec3 sky_radiance(vec3 dir, vec3 sun) {
    return rx_sky_light(dir, sun, frame.sky_strength);
}

float sun_through_clouds(vec3 place) {
    return 1.0;
}
#endif

// The place in a pixel through which its ray goes, in pixels from the top left. It is the centre, or with JITTER a place that fills the
// pixels evenly over the frames (Roberts' sequence R2).
vec2 pixel_place(ivec2 pixel) {
#ifdef JITTER
    // All passes look through the same place, to the last bit.
    precise vec2 turns = vec2(frame.index & 65535u) * vec2(0.7548776662466927, 0.5698402909980532);
    precise vec2 place = vec2(pixel) + fract(turns);
    return place;
#else
    return vec2(pixel) + 0.5;
#endif
}

vec3 pixel_direction(ivec2 pixel, ivec2 size) {
    return rx_camera_direction(frame.view_to_world, frame.tan_half_fov, pixel_place(pixel), vec2(size));
}

// The place in the world, in voxels, that a pixel sees at a distance.
vec3 pixel_world(ivec2 pixel, ivec2 size, float distance) {
    return vec3(frame.camera_cell) + (frame.camera_frac + distance * pixel_direction(pixel, size));
}

// The number that begins all random numbers of a pixel or face in a run.
uint scene_seed(uint own) {
    return rx_hash(own ^ rx_hash(frame.seed));
}

// A first hit in one word: material and face; -1 where there is only sky.
int pack_hit(uint material, uint face) {
    return int(material | face << 16);
}

uint hit_material(int word) {
    return uint(word) & 0xffffu;
}

uint hit_face(int word) {
    return uint(word) >> 16 & RX_FACE_MASK;
}

#endif
