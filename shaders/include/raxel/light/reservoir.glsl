// Reservoirs of points on lamps. One point stands for many points drawn at a place, in earlier frames, or nearby (Bitterli and others,
// "Spatiotemporal reservoir resampling for real-time ray tracing with dynamic direct lighting", 2020). Needs <raxel/world.glsl>, and `lights`
// bound to `world.lights`. A point is a lamp's index and a place on its face, so another place can use it as it is. The target is the light's
// luminance without shadows, times the share that rx_drawn_lamp_weight leaves to points. Close to lamps, no number of points is enough, so a
// cosine ray counts that light.
#ifndef RAXEL_LIGHT_RESERVOIR_GLSL
#define RAXEL_LIGHT_RESERVOIR_GLSL

#include "lamps.glsl"

// A point on a lamp that stands for several compared points.
struct RxReservoir {
    uint light;    // the index of the lamp
    vec2 uv;       // the place on its face
    float weight;  // light of the point times this is, in the mean, the light of all lamps; 0 where nothing was found
    float count;   // of the choices that this one stands for
};

const RxReservoir RX_EMPTY_RESERVOIR = RxReservoir(0u, vec2(0.0), 0.0, 0.0);

// Light of the reservoir's point on a place, without shadows and without the weight. `from` and `normal` as for rx_sample_lamp, `points` as for
// rx_drawn_lamp_weight.
RxLampSample rx_reservoir_light(RxReservoir r, RxRay from, vec3 normal, float points) {
    RxLampSample point = rx_sample_lamp(rx_light(r.light), r.uv, from, normal);
    if (rx_luminance(point.light) > 0.0) point.light *= rx_drawn_lamp_weight(point, points, normal);
    return point;
}

// Luminance of the light of a reservoir's point at a place, which points are chosen by; 0 without a point.
float rx_reservoir_target(RxReservoir r, RxRay from, vec3 normal, float points) {
    return r.light < rx_lights_count() ? rx_luminance(rx_reservoir_light(r, from, normal, points).light) : 0.0;
}

// A point of `candidates`, drawn by power and chosen by target. Draws `candidates` + 1 pairs.
RxReservoir rx_reservoir(uint candidates, inout RxSampler s, RxRay from, vec3 normal, float points) {
    RxReservoir chosen = RX_EMPTY_RESERVOIR;
    chosen.count = 1.0;
    if (rx_lights_count() == 0u) return chosen;
    float sum = 0.0, worth = 0.0, keep = rx_next(s);
    for (uint i = 0u; i < candidates; ++i) {
        RxReservoir point = chosen;
        rx_draw_lamp(s, point.light, point.uv);
        float target = rx_reservoir_target(point, from, normal, points);
        if (rx_takes(target / rx_light(point.light).probability, sum, keep)) {
            chosen = point;
            worth = target;
        }
    }
    if (worth > 0.0) chosen.weight = sum / (float(candidates) * worth);
    return chosen;
}

// In 128 bits; places on faces in 16 bits each.
uvec4 rx_pack_reservoir(RxReservoir r) {
    return uvec4(r.light, packUnorm2x16(r.uv), floatBitsToUint(r.weight), floatBitsToUint(r.count));
}

// The inverse of rx_pack_reservoir.
RxReservoir rx_unpack_reservoir(uvec4 words) {
    return RxReservoir(words.x, unpackUnorm2x16(words.y), uintBitsToFloat(words.z), uintBitsToFloat(words.w));
}

#endif
