// Light along a line through the air, by the tables of sky/transmittance.comp and sky/scattered.comp.
#include <raxel/light/atmosphere.glsl>

uniform sampler2D transmittance;

// Half a texel is left free at each edge.
vec3 to_sun(float radius, float cosine) {
    if (rx_air_meets_ground(radius, cosine)) return vec3(0.0);
    vec2 place = rx_transmittance_place(radius, cosine);
    return textureLod(transmittance, place * (vec2(255.0, 63.0) / vec2(256.0, 64.0)) + 0.5 / vec2(256.0, 64.0), 0.0).rgb;
}
