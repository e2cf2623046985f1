// The sun, the moon and the stars as the camera sees them. Needs scene.glsl.
#ifndef BEAUTY_LIGHTS_ABOVE_GLSL
#define BEAUTY_LIGHTS_ABOVE_GLSL

const float SUN_DISC = 400.0;          // its radiance, of its irradiance. Nature's is 14,600, more than a picture can show
const float MOON_RADIUS = 0.011;       // twice and a half as wide as nature's: more than a few pixels
const float MOON_RADIANCE = 0.30;
const float STAR_RADIANCE = 0.016;     // of the brightest
const float STAR_CELLS = 48.0;         // along each side of a cube around the sky
const float STAR_POLE = 0.82;          // height of the pole of the sky, radians

// The disc, darker at its limb.
vec3 sun_disc(vec3 dir) {
    vec3 sun = frame_true_sun();
    return sun == frame_sun() ? smoothstep(1.0 - 1.6 * RX_SUN_CAP, 1.0 - 0.4 * RX_SUN_CAP, dot(dir, sun)) * SUN_DISC * sun_irradiance(sun) : vec3(0.0);
}

// A ball lit from a side, with darker plains, and the glow around it. `cover` is its share of hidden stars, `wide` the width of a pixel,
// radians.
vec3 moon_disc(vec3 dir, float wide, out float cover) {
    vec3 moon = sky_moon.xyz;
    float away = length(dir - moon);
    cover = 0.0;
    if (sky_moon.w <= 0.0 || dot(dir, moon) < 0.9) return vec3(0.0);
    vec3 t = normalize(cross(moon, vec3(0.0, 1.0, 0.001))), b = cross(t, moon);
    vec2 at = vec2(dot(dir, t), dot(dir, b)) / MOON_RADIUS;
    float square = dot(at, at);
    // The angle between the sun and the eye, as seen from the moon, decides which share is lit. The light comes from the sun's side.
    float phase = 2.0 * sky_night.w - 1.0, side = sqrt(max(1.0 - phase * phase, 0.0));
    vec3 sun = frame_true_sun();
    vec2 sunward = normalize(vec2(dot(sun, t), dot(sun, b)) + vec2(1e-4, 0.0));
    cover = 1.0 - smoothstep(MOON_RADIUS - 0.5 * wide, MOON_RADIUS + 0.5 * wide, away);
    vec3 normal = vec3(at, sqrt(max(1.0 - square, 0.0)));
    float lit = smoothstep(-0.05, 0.25, dot(normal, vec3(sunward * side, phase)));
    float plains = 0.75 + 0.35 * smoothstep(0.35, 0.6, 0.6 * noise2(2.1 * at + 31.0) + 0.4 * noise2(5.3 * at + 7.0));
    vec3 color = vec3(1.0, 0.97, 0.90);
    float glow = 0.010 * sky_night.w / (1.0 + 900.0 * away * away / (MOON_RADIUS * 30.0)) * exp(-6.0 * away);
    return frame.sun_strength * sky_moon.w * MOON_RADIANCE * color * (cover * (lit * plains + 0.004) + glow);
}

// Light of the stars. They turn around the pole as the sun does, and each is at least as wide as a pixel, so that it does not sparkle.
vec3 stars(vec3 dir, float wide) {
    if (sky_moon.w <= 0.0) return vec3(0.0);
    vec3 pole = vec3(0.0, sin(STAR_POLE), -cos(STAR_POLE)), east = vec3(1.0, 0.0, 0.0), north = cross(pole, east), sun = frame_true_sun();
    float turn = atan(dot(sun, north), dot(sun, east)), c = cos(turn), s = sin(turn);
    vec2 across = vec2(dot(dir, east), dot(dir, north));
    vec3 still = vec3(c * across.x + s * across.y, c * across.y - s * across.x, dot(dir, pole));
    vec3 size = abs(still);
    uint axis = size.x > size.y && size.x > size.z ? 0u : size.y > size.z ? 1u : 2u;
    vec2 place = (axis == 0u ? still.yz : axis == 1u ? still.zx : still.xy) / size[axis] * STAR_CELLS;
    ivec2 cell = ivec2(floor(place));
    uint seed = rx_hash(ivec3(cell, int(axis) * 2 + (still[axis] < 0.0 ? 1 : 0)));
    if ((seed & 3u) != 0u) return vec3(0.0);
    vec2 star = vec2(cell) + 0.25 + 0.5 * vec2(noise_value(rx_hash(seed)), noise_value(rx_hash(seed + 1u)));
    // On the cube a radian is this many cells at its nearest.
    float radius = max(0.6 * wide, 0.0006) * STAR_CELLS / size[axis], away = length(place - star) / radius;
    float bright = noise_value(rx_hash(seed + 2u)), warm = noise_value(rx_hash(seed + 3u));
    vec3 color = mix(vec3(0.75, 0.85, 1.0), vec3(1.0, 0.85, 0.7), warm);
    float low = smoothstep(0.0, 0.25, dir.y);
    return frame.sky_strength * sky_moon.w * low * STAR_RADIANCE * pow(bright, 14.0) * exp(-away * away) * color;
}

#endif
