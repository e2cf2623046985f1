// A layer of clouds over the whole world: its thickness, the share of the sun that passes, and a march through
// it. Shadows and visible clouds share one function for the thickness, so they agree. Needs scene.glsl, which
// includes it where a graph defines SKY_TABLE.
#ifndef SKY_CLOUDS_GLSL
#define SKY_CLOUDS_GLSL

#include "noise.glsl"

const float CLOUD_SIZE = 460.0;    // voxels, of the largest patches
const float CLOUD_DEPTH = 17.0;    // optical depth of a column: this times the square of its thickness
const float CLOUD_TAPER = 0.35;    // thickness that is gone at the top of the layer

// 0 where there is no cloud, to about a half. Sixteen look-ups of the hash.
float cloud_thickness(vec2 place) {
    vec2 at = place / CLOUD_SIZE;
    float sum = 0.0, weight = 0.5;
    for (int i = 0; i < 4; ++i) {
        sum += weight * noise2(at);
        at = mat2(1.6, 1.2, -1.2, 1.6) * at + 17.3;
        weight *= 0.5;
    }
    return max(sum - 0.9 * (1.0 - sky_clouds.x), 0.0);
}

// Clouds are there from the zenith down to some degrees above the horizon, where the layer would be cut into stripes.
float cloud_share(float rise) {
    return smoothstep(0.02, 0.22, abs(rise));
}

// The share of the sun, or by night the moon, that passes the clouds and reaches a place of the world. Sixteen look-ups of the hash, and none without clouds.
float sun_through_clouds(vec3 place) {
    vec3 to = frame_sun();
    float rise = sky_clouds.y - place.y;
    if (sky_clouds.x <= 0.0 || rise <= 0.0 || to.y <= 0.02) return 1.0;
    float thick = cloud_thickness(place.xz + to.xz * (rise / to.y));
    return mix(1.0, exp(-CLOUD_DEPTH * thick * thick), cloud_share(to.y));
}

// The part of a ray in the layer. `height` is the height of its start.
bool cloud_span(float height, vec3 dir, out float from, out float until) {
    float low = (sky_clouds.y - height) / dir.y, high = (sky_clouds.y + sky_clouds.z - height) / dir.y;
    from = max(min(low, high), 0.0);
    until = max(low, high);
    return sky_clouds.x > 0.0 && abs(dir.y) > 0.02 && until > from;
}

// Light of the clouds along a ray from `place` of the world, and the share of the light behind them that passes. `shift`, 0 to 1, moves the
// samples of the march. Each sample costs 24 look-ups of the hash, and 16 more in a cloud.
vec4 cloud_march(vec3 place, vec3 dir, vec3 to_sun, int steps, float shift) {
    float from, until;
    if (!cloud_span(place.y, dir, from, until)) return vec4(0.0, 0.0, 0.0, 1.0);
    float size = (until - from) / float(steps), cosine = dot(dir, to_sun);
    vec3 zenith = sky_radiance(vec3(0.0, 1.0, 0.0), to_sun), haze = sky_radiance(normalize(vec3(dir.x, max(dir.y, 0.003), dir.z)), to_sun);
    vec3 sunlight = sun_irradiance(to_sun);
    float forward = 0.17 + 0.55 * pow(max(cosine, 0.0), 10.0);
    vec2 sunward = to_sun.xz / max(to_sun.y, 0.25);
    vec3 light = vec3(0.0);
    float clear = 1.0;
    for (int i = 0; i < steps && clear > 0.01; ++i) {
        vec3 at = place + (from + (float(i) + shift) * size) * dir;
        float level = clamp((at.y - sky_clouds.y) / sky_clouds.z, 0.0, 1.0);
        float here = cloud_thickness(at.xz) - CLOUD_TAPER * level;
        // Eaten away at its edges, above all at the top.
        if (here > 0.0) here -= 0.10 * (0.4 + level) * noise3(at / (0.10 * CLOUD_SIZE));
        if (here <= 0.0) continue;
        float part = 1.0 - exp(-2.0 * CLOUD_DEPTH * CLOUD_TAPER / sky_clouds.z * here * size * smoothstep(0.0, 0.15, level));
        float above = max(cloud_thickness(at.xz + sunward * (0.4 * (1.0 - level) * sky_clouds.z)) - CLOUD_TAPER * level, 0.0);
        float depth = CLOUD_DEPTH * above * above;
        // Light that was scattered often reaches deeper.
        float lit = 0.6 * exp(-depth) + 0.4 * exp(-0.25 * depth);
        light += clear * part * (sunlight * (forward * lit) + zenith * (0.75 + 0.35 * level) + 0.35 * haze);
        clear *= 1.0 - part;
    }
    float share = cloud_share(dir.y);
    return vec4(share * light, mix(1.0, clear, share));
}

#endif
