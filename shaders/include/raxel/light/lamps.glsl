// Light of the world's lamps on a place, by a few of them. Needs <raxel/world.glsl>, and `lights` bound to `world.lights`.
#ifndef RAXEL_LIGHT_LAMPS_GLSL
#define RAXEL_LIGHT_LAMPS_GLSL

#include "lights.glsl"
#include "sampling.glsl"
#include "sampler.glsl"

float rx_luminance(vec3 light) {
    return dot(light, vec3(0.2126, 0.7152, 0.0722));
}

// Light from one point of a lamp.
struct RxLampSample {
    vec3 to;     // from the place that is lit to the point, in voxels
    vec3 light;  // radiance times both cosines / (pi distance squared) over the density: light sent back by a white matt surface
    float density;  // with which a single candidate takes this direction, per steradian
};

// Weight of light found in one of two ways, with densities in the same measure, so that each is used where it is good (Veach's power heuristic).
float rx_power_weight(float own, float other) {
    return own * own / max(own * own + other * other, 1e-30);
}

// The ray that looks whether a lamp is hidden: it ends just before it.
RxRay rx_lamp_ray(RxRay from, vec3 to) {
    return RxRay(from.cell, from.frac, to, 0.9999);
}

// `light` is not divided by any density. `from` is where a ray that leaves the lit face starts, `normal` that face's normal.
RxLampSample rx_sample_lamp(RxLight lamp, vec2 uv, RxRay from, vec3 normal) {
    vec3 to = rx_to_light(lamp, uv, from.cell, from.frac);
    float square = dot(to, to);
    float cosines = max(dot(normal, to), 0.0) * max(-dot(rx_normal(lamp.face), to), 0.0);
    RxMaterial material = rx_material_properties(lamp.material);
    float density = lamp.probability * square * sqrt(square) / max(-dot(rx_normal(lamp.face), to), 1e-9);
    return RxLampSample(to, material.albedo * (material.emission * cosines / (RX_PI * max(square * square, 1e-12))), density);
}

// One of `candidates` points on lamps, chosen by what each would give without shadows (resampled importance sampling: Talbot, Cline and
// Egbert, "Importance resampling for global illumination", 2005). Without bias if light counts only where rx_lamp_ray meets nothing.
// No light where there are no lamps. Draws `candidates` + 1 pairs.
RxLampSample rx_resample_lamps(uint candidates, inout RxSampler s, RxRay from, vec3 normal) {
    RxLampSample chosen = RxLampSample(vec3(0.0), vec3(0.0), 0.0);
    if (rx_lights_count() == 0u) return chosen;
    float sum = 0.0, worth = 0.0, keep = rx_next(s);
    for (uint i = 0u; i < candidates; ++i) {
        // The pick takes the numbers as 32 bits: those of `u` are its upper 24.
        vec2 u = rx_next2(s);
        uint more = rx_hash(s.seed ^ rx_hash(s.index + 0x10001u * s.pair));
        uint index = rx_pick_light(uvec2(uint(u.x * 16777216.0) << 8, more));
        vec2 uv = vec2(fract(u.x * float(rx_lights_count())), u.y);
        RxLight lamp = rx_light(index);
        RxLampSample candidate = rx_sample_lamp(lamp, uv, from, normal);
        float target = rx_luminance(candidate.light), weight = target / lamp.probability;
        if (!(weight > 0.0)) continue;
        sum += weight;
        // One number decides all draws: what is left of it is uniform again.
        float odds = weight / sum;
        if (keep < odds) {
            keep = keep / odds;
            chosen = candidate;
            worth = target;
        } else keep = (keep - odds) / (1.0 - odds);
    }
    if (worth > 0.0) chosen.light *= sum / (float(candidates) * worth);
    return chosen;
}

#endif
