// The sky that is chosen, as a table in the directions of rx_sky_view_place, and the light of its sun. It depends on the sun and the choice alone,
// so that it is made again only when one of them changes.
#version 460
#include <raxel/light/environment.glsl>
#include "skies.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
uniform sampler2D sky_view;
layout(std430) readonly buffer Tables { vec4 through_tables; };  // sunlight that comes through the air, by the tables
layout(std430) writeonly buffer SunLight { vec4 sun_light; };
layout(rgba16f) uniform writeonly image2D outSkyMap;
layout(push_constant) uniform Push {
    float sun_elevation;  // degrees
    float sun_strength;
    float sky_strength;
    uint sky;             // 0 as the judge's, 1 closed form, 2 painted, 3 tables
    bool judged;
} push;

// At this strength, skylight is as strong as the sunlight before it was scattered.
const float NATURAL = 0.6;
#ifdef FAITHFUL
const float BRIGHTENED = 16.0 / RX_AIR_PI;   // of the sky against the sun, in the original
#else
const float BRIGHTENED = 1.0;
#endif

void main() {
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(texel, imageSize(outSkyMap)))) return;
    float e = radians(push.sun_elevation);
    vec3 sun = vec3(cos(e), sin(e), 0.0), dir = rx_sky_view_direction(texel), sky, light;
    uint chosen = push.judged ? 0u : push.sky;
    float natural = push.sun_strength * push.sky_strength / NATURAL;
    if (chosen == 0u) {
        sky = rx_sky_light(dir, sun, push.sky_strength);
        light = rx_sun_light(sun, push.sun_strength);
    } else if (chosen == 1u) {
        sky = BRIGHTENED * natural * closed_sky(dir, sun);
        light = push.sun_strength * closed_sunlight(sun);
    } else if (chosen == 2u) {
        sky = push.sky_strength * painted_sky(dir, sun);
        light = push.sun_strength * painted_sunlight(sun);
    } else {
        sky = natural * texelFetch(sky_view, texel, 0).rgb;
        light = push.sun_strength * through_tables.rgb;
    }
    imageStore(outSkyMap, texel, vec4(max(sky, 0.0), 1.0));
    if (texel == ivec2(0)) sun_light = vec4(light, 1.0);
}
