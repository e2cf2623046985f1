// A clear sky: a gradient from horizon to zenith, warmer towards a low sun, with the sun's disc and its glow.
#ifndef RAXEL_SKY_GLSL
#define RAXEL_SKY_GLSL

// Direction towards the sun. Degrees; azimuth 0 is -z and turns towards +x, elevation is above the horizon.
vec3 rx_sun_direction(float azimuth, float elevation) {
    float a = radians(azimuth), e = radians(elevation);
    return vec3(sin(a) * cos(e), sin(e), -cos(a) * cos(e));
}

// Linear colour of sunlight: white when high, orange near the horizon, none below it.
vec3 rx_sun_color(vec3 sun) {
    float height = clamp(sun.y, 0.0, 1.0);
    vec3 color = mix(vec3(1.0, 0.45, 0.16), vec3(1.0, 0.93, 0.80), smoothstep(0.02, 0.50, height));
    return color * smoothstep(-0.04, 0.06, sun.y);
}

// Linear radiance of the sky without the disc of the sun, for lighting surfaces and fog.
vec3 rx_sky(vec3 dir, vec3 sun) {
    float day = smoothstep(-0.12, 0.25, sun.y);
    vec3 zenith = mix(vec3(0.010, 0.014, 0.035), vec3(0.085, 0.235, 0.60), day);
    vec3 horizon = mix(vec3(0.035, 0.035, 0.060), vec3(0.56, 0.71, 0.90), day);
    float low = (1.0 - smoothstep(0.0, 0.55, abs(sun.y))) * day;
    float towards = 0.5 + 0.5 * dot(dir, sun);
    horizon = mix(horizon, vec3(0.98, 0.56, 0.27), low * towards * towards * 0.8);
    float up = max(dir.y, 0.0);
    vec3 sky = mix(horizon, zenith, 1.0 - exp(-3.2 * up));
    // Below the horizon: haze over unseen ground.
    sky = mix(sky, horizon * 0.72, 1.0 - smoothstep(-0.35, 0.0, dir.y));
    float glow = max(dot(dir, sun), 0.0);
    return sky + rx_sun_color(sun) * (0.10 * pow(glow, 12.0) + 0.22 * pow(glow, 90.0));
}

// The sky as the camera sees it: with the disc.
vec3 rx_sky_with_sun(vec3 dir, vec3 sun) {
    float disc = smoothstep(0.99955, 0.99980, dot(dir, sun));
    return rx_sky(dir, sun) + 6.0 * disc * rx_sun_color(sun);
}

#endif
