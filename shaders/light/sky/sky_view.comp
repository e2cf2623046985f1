// Table of the sky's radiance, and the sunlight that reaches the ground. Below the horizon lies ground in the haze.
#version 460
#include <raxel/sky.glsl>
#include "air.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
uniform sampler2D scattered;
layout(rgba16f) uniform writeonly image2D outSkyView;
layout(std430) writeonly buffer SunLight { vec4 sun_light; vec4 sky_way; vec4 sky_moon; vec4 sky_night; vec4 sky_clouds; };   // scene.glsl
#ifdef NIGHT
layout(push_constant) uniform Push { float elevation; float azimuth; float moon_elevation; float moon_azimuth; float moon_phase; float clouds; float cloud_height; } push;
#include "night.glsl"
#else
layout(push_constant) uniform Push { float elevation; } push;
#endif

const int STEPS = 32, STEPS_DOWN = 8;

void main() {
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(texel, ivec2(192, 108)))) return;
    float e = radians(push.elevation), start = RX_AIR_GROUND + RX_AIR_EYE;
    vec3 sun = vec3(cos(e), sin(e), 0.0), dir = rx_sky_view_direction(texel);
    bool ground = rx_air_meets_ground(start, dir.y);
    float end = rx_air_sphere(start, dir.y, ground ? RX_AIR_GROUND : RX_AIR_TOP);
    float cosine = dot(dir, sun), rayleigh = rx_rayleigh_phase(cosine), mie = rx_mie_phase(cosine, RX_AIR_MIE_G);
    vec3 light = vec3(0.0), clear = vec3(1.0);
    // The way down is short, but for that along the horizon.
    int steps = ground && dir.y < -0.02 ? STEPS_DOWN : STEPS;
    for (int i = 0; i < steps; ++i) {
        // Shorter steps near the eye, where the air is thick.
        float from = float(i) / float(steps), to = float(i + 1) / float(steps);
        float size = end * (to * to - from * from);
        vec3 at = vec3(0.0, start, 0.0) + end * 0.5 * (to * to + from * from) * dir;
        float radius = length(at), sun_cosine = dot(at, sun) / radius;
        RxAir air = rx_air(radius - RX_AIR_GROUND);
        vec3 through = exp(-air.extinction * size);
        vec3 many = textureLod(scattered, rx_scattered_place(radius, sun_cosine), 0.0).rgb;
        vec3 sent = to_sun(radius, sun_cosine) * (air.rayleigh * rayleigh + air.mie * mie) + many * (air.rayleigh + air.mie);
        light += clear * sent * (1.0 - through) / max(air.extinction, vec3(1e-9));
        clear *= through;
    }
    if (ground) {
        vec3 at = normalize(vec3(0.0, start, 0.0) + end * dir);
        float height = dot(at, sun);
        vec3 many = textureLod(scattered, rx_scattered_place(RX_AIR_GROUND, height), 0.0).rgb * RX_AIR_PI;
        light += clear * RX_AIR_GROUND_ALBEDO / RX_AIR_PI * (to_sun(RX_AIR_GROUND, height) * max(height, 0.0) + many);
    }
    // In units in which sunlight above the air has the irradiance pi.
    imageStore(outSkyView, texel, vec4(RX_AIR_PI * light, 1.0));
    if (texel != ivec2(0)) return;
    vec3 sunlight = RX_AIR_PI * to_sun(start, sun.y);
    sun_light = vec4(sunlight, 1.0);
    sky_way = sky_moon = sky_night = sky_clouds = vec4(0.0);
#ifdef NIGHT
    vec3 moon = rx_sun_direction(push.moon_azimuth, push.moon_elevation);
    float night = night_share(push.elevation), phase = clamp(push.moon_phase, 0.0, 1.0);
    vec3 moonlight = night * phase * MOON_LIGHT * RX_AIR_PI * to_sun(start, moon.y);
    bool moonlit = moonlight.g > sunlight.g;
    if (moonlit) sun_light.rgb = moonlight;
    sky_way = vec4(moonlit ? moon : rx_sun_direction(push.azimuth, push.elevation), 0.0);
    sky_moon = vec4(moon, night);
    sky_night = vec4(night * mix(NIGHT_DARK, NIGHT_MOONLIT, moon.y > 0.0 ? phase : 0.0), phase);
    sky_clouds = vec4(push.clouds, push.cloud_height, 0.4 * push.cloud_height, 0.0);
#endif
}
