// Light of the world's lamps on a place, by a few of them. Needs <raxel/world.glsl>, and `lights` bound to `world.lights`.
#ifndef RAXEL_LIGHT_LAMPS_GLSL
#define RAXEL_LIGHT_LAMPS_GLSL

#include "lights.glsl"
#include "sampling.glsl"
#include "sampler.glsl"

// Luminance of linear light (ITU-R BT.709).
float rx_luminance(vec3 light) {
    return dot(light, vec3(0.2126, 0.7152, 0.0722));
}

// Light from one point of a lamp.
struct RxLampSample {
    vec3 to;     // from the place that is lit to the point, in voxels
    vec3 light;  // radiance times both cosines / (pi distance squared) over the density: light sent back by a white matt surface
    float density;  // the density with which one candidate takes this direction, per steradian
};

// The weight of light that two ways can find (Veach's power heuristic). Each way counts most where it is good. Both densities are in the same measure.
float rx_power_weight(float own, float other) {
    return own * own / max(own * own + other * other, 1e-30);
}

// The ray that looks whether a lamp is hidden: it ends just before it.
RxRay rx_lamp_ray(RxRay from, vec3 to) {
    return RxRay(from.cell, from.frac, to, 0.9999);
}

// Light of a point that lies at `to` on a face with the normal `lamp_normal`, drawn with `probability` by area. `light` is not divided by any density.
RxLampSample rx_lamp_sample(vec3 to, vec3 lamp_normal, RxMaterial material, float probability, vec3 normal) {
    float square = dot(to, to);
    float cosines = max(dot(normal, to), 0.0) * max(-dot(lamp_normal, to), 0.0);
    float density = probability * square * sqrt(square) / max(-dot(lamp_normal, to), 1e-9);
    return RxLampSample(to, material.albedo * (material.emission * cosines / (RX_PI * max(square * square, 1e-12))), density);
}

// The same of a lamp of the list. `from` is where a ray that leaves the lit face starts, `normal` that face's normal.
RxLampSample rx_sample_lamp(RxLight lamp, vec2 uv, RxRay from, vec3 normal) {
    return rx_lamp_sample(rx_to_light(lamp, uv, from.cell, from.frac), rx_normal(lamp.face), rx_material_properties(lamp.material), lamp.probability, normal);
}

// A choice between things that come one after the other: `sum` of their shares so far, and `keep`, a number in [0, 1) that decides. True if
// the new one, with the share `share`, takes the place of the old one.
bool rx_takes(float share, inout float sum, inout float keep) {
    if (!(share > 0.0)) return false;
    sum += share;
    // One number decides all draws: its remainder is uniform again.
    float odds = share / sum;
    bool takes = keep < odds;
    keep = takes ? keep / odds : (keep - odds) / (1.0 - odds);
    return takes;
}

// A point on a lamp, drawn in proportion to the lamp's power: its index, and the place on its face. There are lamps. Draws a pair.
void rx_draw_lamp(inout RxSampler s, out uint index, out vec2 uv) {
    // The pick takes numbers of 32 bits: those of `u` are the upper 24, and the remainder is the place.
    vec2 u = rx_next2(s);
    uint more = rx_hash(s.seed ^ rx_hash(s.index + 0x10001u * s.pair)), part, spacing;
    uint bits = uint(u.x * 16777216.0) << 8 | more & 255u;
    index = rx_pick_light(uvec2(bits, more), part, spacing);
    if (lights.groups > 0u) {
        // With many groups of many lamps, few bits of the number remain: the part between the steps is drawn again.
        uint between, low;
        umulExtended(rx_hash(more), spacing, between, low);
        part += between;
    }
    uv = vec2(float(part >> 8) * 5.9604644775390625e-8, u.y);
}

// The share of a lamp's light that drawn points count. A cosine ray from the place counts the rest: the lamps that it meets, by
// rx_met_lamp_weight. `points` is the number of points for each cosine ray, in effect: any number gives the same light, with other
// noise.
float rx_drawn_lamp_weight(RxLampSample lamp, float points, vec3 normal) {
    return rx_power_weight(points * lamp.density, max(dot(normal, normalize(lamp.to)), 0.0) / RX_PI);
}

// The weight of a lamp that a cosine ray has met: `radiance` is the lamp's, `t` is the ray's length, `cosine` is the ray's cosine at its start,
// and `facing` the one at its end.
float rx_met_lamp_weight(vec3 radiance, float cosine, float facing, float t, float points) {
    return rx_power_weight(max(cosine, 0.0) / RX_PI, points * rx_light_probability(radiance) * t * t / max(facing, 1e-6));
}

// Chooses one of `candidates` points on lamps by its light without shadows (resampled importance sampling: Talbot,
// Cline and Egbert, "Importance resampling for global illumination", 2005). Without bias if light counts only where rx_lamp_ray meets
// nothing. With `points` above 0, light is only the share of rx_drawn_lamp_weight. No light where there are no lamps. Draws `candidates` +
// 1 pairs.
RxLampSample rx_resample_lamps(uint candidates, inout RxSampler s, RxRay from, vec3 normal, float points) {
    RxLampSample chosen = RxLampSample(vec3(0.0), vec3(0.0), 0.0);
    if (rx_lights_count() == 0u) return chosen;
    float sum = 0.0, worth = 0.0, keep = rx_next(s);
    for (uint i = 0u; i < candidates; ++i) {
        uint index;
        vec2 uv;
        rx_draw_lamp(s, index, uv);
        RxLight lamp = rx_light(index);
        RxLampSample candidate = rx_sample_lamp(lamp, uv, from, normal);
        float target = rx_luminance(candidate.light);
        if (!(target > 0.0)) continue;
        if (points > 0.0) {
            float part = rx_drawn_lamp_weight(candidate, points, normal);
            candidate.light *= part;
            target *= part;
        }
        if (rx_takes(target / lamp.probability, sum, keep)) {
            chosen = candidate;
            worth = target;
        }
    }
    if (worth > 0.0) chosen.light *= sum / (float(candidates) * worth);
    return chosen;
}

#endif
