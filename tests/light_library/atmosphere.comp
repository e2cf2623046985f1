#version 460
#include <raxel/random.glsl>
#include <raxel/light/atmosphere.glsl>
layout(local_size_x = 1) in;
layout(std430) buffer Results { float results[]; };

void main() {
    uint seed = 3u;
    float off = 0.0, off_sky = 0.0;
    for (int i = 0; i < 4000; ++i) {
        vec2 place = vec2(rx_random(seed), 0.02 + 0.98 * rx_random(seed));
        float radius, cosine;
        rx_transmittance_at(place, radius, cosine);
        vec2 back = rx_transmittance_place(radius, cosine);
        off = max(off, max(abs(back.x - place.x), abs(back.y - place.y)));
        ivec2 texel = ivec2(rx_random(seed) * 191.99, rx_random(seed) * 107.99);
        vec2 there = rx_sky_view_place(rx_sky_view_direction(texel), vec3(0.8, 0.6, 0.0));
        // At the poles all angles around are one.
        if (texel.y > 2 && texel.y < 105) off_sky = max(off_sky, abs(there.x - (float(texel.x) + 0.5) / 192.0));
        off_sky = max(off_sky, abs(there.y - (float(texel.y) + 0.5) / 108.0));
    }
    results[0] = off;
    results[1] = off_sky;
    float rayleigh = 0.0, mie = 0.0;
    for (int i = 0; i < 4000; ++i) {
        float cosine = (float(i) + 0.5) / 2000.0 - 1.0;
        rayleigh += 4.0 * RX_AIR_PI / 4000.0 * rx_rayleigh_phase(cosine);
        mie += 4.0 * RX_AIR_PI / 4000.0 * rx_mie_phase(cosine, RX_AIR_MIE_G);
    }
    results[2] = rayleigh;
    results[3] = mie;
    results[4] = rx_air_transmittance(RX_AIR_GROUND, 1.0, 40).y;
}
