// Table of light that was scattered more than once: 64 directions from each height and for each height of the sun. The light that the
// second scattering sends on continues as a geometric series.
#version 460
#include "air.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba16f) uniform writeonly image2D outScattered;

void main() {
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(texel, ivec2(32)))) return;
    float sun_cosine = 2.0 * float(texel.x) / 31.0 - 1.0;
    float start = RX_AIR_GROUND + clamp(float(texel.y) / 31.0 * (RX_AIR_TOP - RX_AIR_GROUND), 0.01, RX_AIR_TOP - RX_AIR_GROUND - 0.01);
    vec3 sun = vec3(sqrt(max(1.0 - sun_cosine * sun_cosine, 0.0)), sun_cosine, 0.0);
    vec3 second = vec3(0.0), again = vec3(0.0);
    for (int k = 0; k < 64; ++k) {
        float z = 1.0 - (2.0 * float(k >> 3) + 1.0) / 8.0, angle = 2.0 * RX_AIR_PI * (float(k & 7) + 0.5) / 8.0;
        vec3 dir = vec3(sqrt(1.0 - z * z) * cos(angle), z, sqrt(1.0 - z * z) * sin(angle));
        bool ground = rx_air_meets_ground(start, dir.y);
        float end = rx_air_sphere(start, dir.y, ground ? RX_AIR_GROUND : RX_AIR_TOP), size = end / 20.0;
        vec3 clear = vec3(1.0);
        for (int i = 0; i < 20; ++i) {
            vec3 at = vec3(0.0, start, 0.0) + (float(i) + 0.5) * size * dir;
            float radius = length(at);
            RxAir air = rx_air(radius - RX_AIR_GROUND);
            vec3 through = exp(-air.extinction * size), scattering = air.rayleigh + air.mie;
            vec3 whole = clear * (1.0 - through) / max(air.extinction, vec3(1e-9));
            second += whole * scattering * to_sun(radius, dot(at, sun) / radius) / (4.0 * RX_AIR_PI);
            again += whole * scattering;
            clear *= through;
        }
        if (ground) {
            vec3 at = normalize(vec3(0.0, start, 0.0) + end * dir);
            float cosine = dot(at, sun);
            second += clear * to_sun(RX_AIR_GROUND, cosine) * max(cosine, 0.0) * RX_AIR_GROUND_ALBEDO / RX_AIR_PI;
        }
    }
    imageStore(outScattered, texel, vec4(second / 64.0 / (1.0 - again / 64.0), 1.0));
}
