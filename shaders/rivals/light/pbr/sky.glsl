// The sky of a graph over graphs/rivals/light/pbr_sky.toml, from its tables, and the parts that are visible but light nothing.
#include <raxel/light/atmosphere.glsl>

uniform sampler2D skyMap;
layout(std430) readonly buffer SunLight { vec4 sun_light; };  // irradiance on a plane that faces the sun

vec3 sky_from(vec3 dir, vec3 sun) {
    return textureLod(skyMap, rx_sky_view_place(dir, sun), 0.0).rgb;
}

// Stars in a grid over the upper half, as in the fourth seed.
float stars(vec3 dir) {
    if (dir.y <= 0.0) return 0.0;
    ivec2 at = ivec2(floor(dir.xz / (dir.y + 1.0) * 700.0 + 234.0));
    float chance = float(rx_hash(ivec3(at, 7)) >> 8) * 5.9604644775390625e-8;
    return 0.5 * smoothstep(0.98, 1.0, chance) * dir.y;
}

// The camera's view where it sees no voxel. The disc has a thousandth of its radiance, as much as a screen can show.
vec3 sky_seen(vec3 dir, vec3 sun, uint sky, bool judged) {
    vec3 light = sky_from(dir, sun);
    if (judged) return light;
    // Below the horizon lies no ground of this world, only haze.
    if (dir.y < 0.0) light = mix(sky_from(normalize(vec3(dir.x, 0.003, dir.z)), sun), light, 1.0 - smoothstep(-0.6, 0.0, dir.y));
    float disc = smoothstep(1.0 - 1.6 * RX_SUN_CAP, 1.0 - 0.4 * RX_SUN_CAP, dot(dir, sun));
    float night = sky == 1u || sky == 2u ? 0.3 * (1.0 - smoothstep(-0.3, 0.0, sun.y)) : 0.0;
    return light + disc * 15.0 * sun_light.rgb + night * stars(dir);
}
