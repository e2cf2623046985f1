// Skies without tables, as radiance and sunlight for a sun with the irradiance pi above the air. `dir` and `sun` are unit
// vectors along the view and to the sun; y is up.

// 1: single scattering in closed form. The optical depth of gas that thins out exponentially is taken as its density here times the way to
// the end of a sphere one scale height above (the fourth seed's sky, after "Flat atmosphere" by SkyTheDragon). FAITHFUL keeps
// the original's numbers, even the wrong ones.
#include <raxel/light/atmosphere.glsl>

#ifdef FAITHFUL
const float EYE_HEIGHT = 0.8;                     // km
const vec2 OZONE_SHELL = vec2(35.5, 32.5);        // a lost zero in a coefficient puts the lower edge above the upper one: ozone adds light
#else
const float EYE_HEIGHT = RX_AIR_EYE;
const vec2 OZONE_SHELL = vec2(17.5, 32.5);        // km: as much ozone as the tent of rx_air between 10 and 40 km
#endif
const vec2 SCALE_HEIGHTS = vec2(8.0, 1.2);        // Rayleigh, Mie; km

// Kilometres of full density from `at` along `dir` to the end of the air, which goes up: Rayleigh, Mie, ozone. `at` is from the Earth's centre.
vec3 depth_upwards(vec3 at, vec3 dir) {
    float along = dot(at, dir), square = dot(at, at), radius = sqrt(square);
    vec4 spheres = vec4(max(radius + SCALE_HEIGHTS, vec2(RX_AIR_GROUND)), max(vec2(radius), RX_AIR_GROUND + OZONE_SHELL));
    vec2 density = exp(-max(radius - RX_AIR_GROUND, 0.0) / SCALE_HEIGHTS);
    vec4 way = sqrt(max(along * along + spheres * spheres - square, 0.0));
    return vec3(density * (way.xy - along), way.w - way.z);
}

// The same for any direction. A way that goes down first has the lowest point of its line halfway: twice from there, less the part behind.
vec3 optical_depth(vec3 at, vec3 dir) {
    float along = dot(at, dir);
    return along > 0.0 ? depth_upwards(at, dir) : 2.0 * depth_upwards(at - along * dir, dir) - depth_upwards(at, -dir);
}

vec3 extinction(vec3 depth) {
    return RX_AIR_RAYLEIGH * depth.x + RX_AIR_MIE_EXTINCTION * depth.y + RX_AIR_OZONE * depth.z;
}

// Mean of exp(-x) between a and b.
vec3 mean_transmittance(vec3 a, vec3 b) {
    vec3 d = b - a;
    return mix((exp(-a) - exp(-b)) / mix(d, vec3(1.0), lessThan(abs(d), vec3(1e-4))), exp(-0.5 * (a + b)), lessThan(abs(d), vec3(1e-4)));
}

vec3 closed_sky(vec3 dir, vec3 sun) {
    vec3 eye = vec3(0.0, RX_AIR_GROUND + EYE_HEIGHT, 0.0);
    bool ground = rx_air_meets_ground(eye.y, dir.y);
    vec3 view = optical_depth(eye, dir), from_sun = optical_depth(eye, sun), view_end = vec3(0.0), from_sun_end = vec3(0.0);
    if (ground) {
        vec3 end = eye + rx_air_sphere(eye.y, dir.y, RX_AIR_GROUND) * dir;
        view_end = optical_depth(end, dir);
        from_sun_end = optical_depth(end, sun);
    }
    vec3 through = mean_transmittance(extinction(from_sun), extinction(from_sun_end + view - view_end));
    float cosine = dot(dir, sun);
    vec3 scattered = (view - view_end).x * RX_AIR_RAYLEIGH * rx_rayleigh_phase(cosine) + (view - view_end).y * RX_AIR_MIE * rx_mie_phase(cosine, RX_AIR_MIE_G);
    // Below the horizon the Earth's shadow is not part of the model: it fades out, as in the original.
    return RX_AIR_PI * through * scattered * smoothstep(-0.1, 0.1, sun.y);
}

vec3 closed_sunlight(vec3 sun) {
    vec3 eye = vec3(0.0, RX_AIR_GROUND + EYE_HEIGHT, 0.0);
    return rx_air_meets_ground(eye.y, sun.y) ? vec3(0.0) : RX_AIR_PI * exp(-extinction(optical_depth(eye, sun)));
}

// 2: gradients for day, dusk and night (the fourth seed's other sky, after "Fast sky" by TheNuclearWolf).
vec3 painted_sky(vec3 dir, vec3 sun) {
    float day = smoothstep(-0.1, 0.1, sun.y), dusk = smoothstep(-0.3, 0.3, sun.y) * (1.0 - day), night = 1.0 - smoothstep(-0.3, 0.0, sun.y);
    float horizon = pow(1.0 - max(dir.y, 0.0), 6.0 + night);
    vec3 sky = mix(vec3(0.02, 0.02, 0.04), vec3(0.04, 0.05, 0.08), horizon);
    sky = mix(sky, mix(vec3(0.20, 0.15, 0.30), vec3(1.0, 0.5, 0.2), horizon), dusk);
    sky = mix(sky, mix(vec3(0.2, 0.4, 0.8), vec3(0.8, 0.9, 1.0), horizon), day);
    sky += day * 0.5 * smoothstep(0.5, 1.5, dot(dir, sun));
    return sky + night * 0.5 * vec3(0.6, 0.7, 0.9) * pow(max(-dot(dir, sun), 0.0), 32.0);
}

// Its colours were written for a screen and are brightened once more, as in the original.
vec3 painted_sunlight(vec3 sun) {
    vec3 noon = pow(vec3(252.0, 232.0, 212.0) / 255.0, vec3(1.0 / 2.2)), low = pow(vec3(249.0, 128.0, 7.0) / 255.0, vec3(1.0 / 2.2));
    return RX_AIR_PI * mix(low, noon, smoothstep(0.0, 0.2, sun.y)) * smoothstep(-0.1, 0.1, sun.y);
}
