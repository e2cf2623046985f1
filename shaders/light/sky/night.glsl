// The brightness of the night, for a sun with an irradiance of pi above the air. The night is brighter against the day than in nature, because
// one exposure has to hold both a lamp and the land.

const vec3 MOON_LIGHT = vec3(0.0125, 0.0150, 0.0190);          // a full moon's light of the sun's
const vec3 NIGHT_DARK = vec3(0.00012, 0.00016, 0.00030);       // radiance of the sky at the zenith without a moon
const vec3 NIGHT_MOONLIT = vec3(0.00050, 0.00085, 0.00190);    // the same under a full moon

// From none, when the sun is at the horizon, to all of it at eight degrees below.
float night_share(float elevation) {
    return 1.0 - smoothstep(-8.0, -1.0, elevation);
}
