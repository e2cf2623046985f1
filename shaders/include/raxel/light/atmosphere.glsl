// The air of the Earth: Rayleigh and Mie scattering and ozone, by tables (Hillaire, "A scalable and production ready sky and atmosphere
// rendering technique", 2020). Distances are in km, radiance is for sunlight with an irradiance of 1 above the air.
//
// Three tables depend on the height of the sun alone, so that they are filled only when it moves:
//
//     transmittance   256 x 64, rgba16f    from a height, towards an angle, to the end of the air
//     scattered        32 x 32, rgba16f    all light that was scattered more than once, the same from all sides
//     sky view        192 x 108, rgba16f   radiance of the sky as seen from RX_AIR_EYE above the ground
#ifndef RAXEL_LIGHT_ATMOSPHERE_GLSL
#define RAXEL_LIGHT_ATMOSPHERE_GLSL

const float RX_AIR_GROUND = 6360.0;
const float RX_AIR_TOP = 6460.0;
const float RX_AIR_EYE = 0.3;
const vec3 RX_AIR_RAYLEIGH = vec3(5.802, 13.558, 33.1) * 1e-3;
const float RX_AIR_MIE = 3.996e-3;
const float RX_AIR_MIE_EXTINCTION = 4.44e-3;
const vec3 RX_AIR_OZONE = vec3(0.650, 1.881, 0.085) * 1e-3;
const float RX_AIR_MIE_G = 0.8;
const vec3 RX_AIR_GROUND_ALBEDO = vec3(0.20, 0.19, 0.15);
const float RX_AIR_PI = 3.14159265358979;

// Scattering by both kinds and the whole loss, per km.
struct RxAir {
    vec3 rayleigh;
    float mie;
    vec3 extinction;
};

// The air at a height in km above the ground.
RxAir rx_air(float height) {
    float thin = exp(-height / 8.0), hazy = exp(-height / 1.2), ozone = max(0.0, 1.0 - abs(height - 25.0) / 15.0);
    RxAir air;
    air.rayleigh = RX_AIR_RAYLEIGH * thin;
    air.mie = RX_AIR_MIE * hazy;
    air.extinction = air.rayleigh + RX_AIR_MIE_EXTINCTION * hazy + RX_AIR_OZONE * ozone;
    return air;
}

// The phase function of Rayleigh scattering, by the cosine of the angle.
float rx_rayleigh_phase(float cosine) {
    return 3.0 / (16.0 * RX_AIR_PI) * (1.0 + cosine * cosine);
}

// Cornette and Shanks 1992.
float rx_mie_phase(float cosine, float g) {
    float k = 3.0 / (8.0 * RX_AIR_PI) * (1.0 - g * g) / (2.0 + g * g);
    return k * (1.0 + cosine * cosine) / pow(max(1.0 + g * g - 2.0 * g * cosine, 1e-4), 1.5);
}

// Distance to a sphere around the Earth's centre: the nearest crossing ahead, or -1.
float rx_air_sphere(float radius, float cosine, float sphere) {
    float square = radius * radius * (cosine * cosine - 1.0) + sphere * sphere;
    if (square < 0.0) return -1.0;
    float root = sqrt(square), near = -radius * cosine - root, far = -radius * cosine + root;
    return near > 0.0 ? near : far > 0.0 ? far : -1.0;
}

// Whether a ray that starts at a radius meets the ground; `cosine` is that of its angle from the zenith.
bool rx_air_meets_ground(float radius, float cosine) {
    return cosine < 0.0 && radius * radius * (cosine * cosine - 1.0) + RX_AIR_GROUND * RX_AIR_GROUND >= 0.0;
}

// Maps a height (as a radius) and a cosine of the angle from the zenith to a place in a table, and back (Bruneton and Neyret 2008). It is finer
// towards the horizon.
vec2 rx_transmittance_place(float radius, float cosine) {
    float h = sqrt(RX_AIR_TOP * RX_AIR_TOP - RX_AIR_GROUND * RX_AIR_GROUND);
    float rho = sqrt(max(radius * radius - RX_AIR_GROUND * RX_AIR_GROUND, 0.0));
    float d = max(-radius * cosine + sqrt(max(radius * radius * (cosine * cosine - 1.0) + RX_AIR_TOP * RX_AIR_TOP, 0.0)), 0.0);
    float least = RX_AIR_TOP - radius, most = rho + h;
    return vec2((d - least) / (most - least), rho / h);
}

// The inverse of rx_transmittance_place.
void rx_transmittance_at(vec2 place, out float radius, out float cosine) {
    float h = sqrt(RX_AIR_TOP * RX_AIR_TOP - RX_AIR_GROUND * RX_AIR_GROUND), rho = h * place.y;
    radius = sqrt(rho * rho + RX_AIR_GROUND * RX_AIR_GROUND);
    float least = RX_AIR_TOP - radius, most = rho + h, d = least + place.x * (most - least);
    cosine = d == 0.0 ? 1.0 : clamp((h * h - rho * rho - d * d) / (2.0 * radius * d), -1.0, 1.0);
}

// Share of the light that goes through all of the air above, in `steps` steps; none through the ground.
vec3 rx_air_transmittance(float radius, float cosine, int steps) {
    float length = rx_air_sphere(radius, cosine, RX_AIR_TOP), size = length / float(steps);
    vec3 depth = vec3(0.0);
    for (int i = 0; i < steps; ++i) {
        float t = (float(i) + 0.5) * size;
        depth += size * rx_air(sqrt(max(radius * radius + t * t + 2.0 * radius * t * cosine, 0.0)) - RX_AIR_GROUND).extinction;
    }
    return exp(-depth);
}

// The place in the table `scattered` of a height (as a radius) and the cosine of the sun's angle from the zenith.
vec2 rx_scattered_place(float radius, float sun_cosine) {
    return vec2(0.5 + 0.5 * sun_cosine, clamp((radius - RX_AIR_GROUND) / (RX_AIR_TOP - RX_AIR_GROUND), 0.0, 1.0)) * (31.0 / 32.0) + 0.5 / 32.0;
}

// Maps a direction to a place in the table of the sky, and back. x is the angle from the sun around the vertical, 0 to pi. y is the angle above
// or below the horizon, finer near it. Half a texel is left free at each edge, so that filtering does not reach across.
vec2 rx_sky_view_place(vec3 dir, vec3 sun) {
    float length_d = length(dir.xz), length_s = length(sun.xz);
    float around = length_d * length_s < 1e-6 ? 1.0 : clamp(dot(dir.xz, sun.xz) / (length_d * length_s), -1.0, 1.0);
    float above = asin(clamp(dir.y, -1.0, 1.0)) / (0.5 * RX_AIR_PI);
    vec2 place = vec2(acos(around) / RX_AIR_PI, 0.5 + 0.5 * sign(above) * sqrt(abs(above)));
    return place * (vec2(191.0, 107.0) / vec2(192.0, 108.0)) + 0.5 / vec2(192.0, 108.0);
}

// In a frame with the sun over +x.
vec3 rx_sky_view_direction(ivec2 texel) {
    vec2 place = vec2(texel) / vec2(191.0, 107.0);
    float around = RX_AIR_PI * place.x, s = 2.0 * place.y - 1.0, above = 0.5 * RX_AIR_PI * sign(s) * s * s;
    return vec3(cos(above) * cos(around), sin(above), cos(above) * sin(around));
}

#endif
