// Lamps that are known to light a place. Each cell of 16 voxels has, for each of the six directions that a face looks in, a list of voxel faces that have lit a face in it
// lately. Lamps that a path compares are drawn in several ways: half from that list, a quarter from lists of lamps that are near (near_lamps.glsl), the others by power from all
// lamps. Each counts by the true density of all ways together, so the lists add no light and take none, whatever is in them. What a list names may be gone by now: the voxel
// itself is asked. Needs <raxel/world.glsl>, scene.glsl and <raxel/light/lamps.glsl>.
#include "near_lamps.glsl"
#include "lamp_voxel.glsl"

const uint KNOWN_PLACE = (1u << 27) - 1u;    // of a word: the place from the middle of the cell in three bytes, the face; above it, log2 of the light
const float KNOWN_LEAST = -24.0;             // log2 of the faintest light
const float UNKNOWN_WORTH = 0.25;            // of a lamp that has not been seen yet, beside one that has

layout(std430) readonly buffer Known { uvec4 known[]; };  // four words of a list
layout(std430) buffer Found { uint found[]; };       // what this frame adds

ivec3 known_corner;      // of places in the list
uint known_first;        // its first word
float known_sum;         // of the shares of all in it
ivec3 known_voxel;       // the place
vec4 known_ways;         // shares of the lamps that are drawn from the list, from the two lists of near lamps, and by power

float known_share(uint word) {
    return word == 0u ? 0.0 : exp2(float(word >> 27));
}

// Before lamps are drawn for a place. Without `lists`, all are drawn by power.
void known_begin(ivec3 voxel, uint face, bool lists) {
    ivec3 cell = voxel >> 4;
    known_voxel = voxel;
    known_corner = cell * 16 + 8 - 128;
    known_first = (rx_hash(rx_hash(cell) + face) & KNOWN_CELLS - 1u) * KNOWN_EACH;
    known_sum = 0.0;
    known_ways = vec4(0.0, 0.0, 0.0, 1.0);
    if (!lists || rx_lights_count() == 0u) return;
    for (uint i = 0u; i < KNOWN_EACH / 4u; ++i) {
        uvec4 words = known[known_first / 4u + i];
        for (int k = 0; k < 4; ++k) known_sum += known_share(words[k]);
    }
    known_ways = known_sum > 0.0 ? vec4(0.5, 0.125, 0.125, 0.25) : vec4(0.0, 0.25, 0.25, 0.5);
}

// The place of a voxel's face in a list, or KNOWN_PLACE if it is too far away.
uint known_place(ivec3 voxel, uint face) {
    uvec3 p = uvec3(voxel - known_corner);
    return ((p.x | p.y | p.z) >> 8) != 0u ? KNOWN_PLACE : p.x | p.y << 8 | p.z << 16 | face << 24;
}

uint known_slot(uint place) {
    return known_first + (rx_hash(place) & KNOWN_EACH - 1u);
}

uint known_word(uint at) {
    return known[at / 4u][at % 4u];
}

// Whether a voxel's face is in the list of near lamps.
bool near_lists(ivec3 voxel, uint face, uint size) {
    ivec3 cell = known_voxel >> near_log2(size);
    uint place = near_place(voxel, face, cell, size);
    if (place > NEAR_PLACE) return false;
    uint word = known_word(near_first(cell, size) + near_slot(place));
    return word != 0u && (word & NEAR_PLACE) == place;
}

// How often a voxel's face, whose radiance is given, is drawn by a candidate, by area; `listed` says whether it is known to light the place.
float known_density(ivec3 voxel, uint face, vec3 radiance, out bool listed) {
    listed = false;
    float density = known_ways.w * rx_light_probability(radiance);
    if (known_ways.x > 0.0) {
        uint place = known_place(voxel, face), word = known_word(known_slot(place));
        listed = place != KNOWN_PLACE && (word & KNOWN_PLACE) == place && word != 0u;
        if (listed) density += known_ways.x * known_share(word) / known_sum;
    }
    for (uint size = 0u; size < NEAR_SIZES; ++size) {
        float way = size == 0u ? known_ways.y : known_ways.z;
        if (way > 0.0 && near_lists(voxel, face, size)) density += way / float(NEAR_EACH);
    }
    return density;
}

// A voxel's face gives a place so much light, unhidden.
void known_add(ivec3 voxel, uint face, float light) {
    uint place = known_place(voxel, face);
    if (place == KNOWN_PLACE || !(light > 0.0)) return;
    uint level = uint(clamp(log2(light) - KNOWN_LEAST, 1.0, 31.0));
    atomicMax(found[known_slot(place)], level << 27 | place);
}

// A face of the list, drawn by its share. `uv` are two random numbers, and then the place on the face.
void known_draw(inout vec2 uv, out ivec3 voxel, out uint face) {
    float left = uv.x * known_sum;
    uint chosen = 0u;
    bool done = false;
    for (uint i = 0u; i < KNOWN_EACH / 4u && !done; ++i) {
        uvec4 words = known[known_first / 4u + i];
        for (int k = 0; k < 4; ++k) {
            float share = known_share(words[k]);
            if (done || share <= 0.0) continue;
            chosen = words[k];
            // What is left of the number is the place on the face.
            uv.x = min(left / share, 0.99999994);
            done = left < share;
            left -= share;
        }
    }
    voxel = known_corner + ivec3(uvec3(chosen, chosen >> 8, chosen >> 16) & 255u);
    face = chosen >> 24 & 7u;
}

// The same from the list of near lamps, each place of it alike; false if that is empty.
bool near_draw(uint size, inout vec2 uv, out ivec3 voxel, out uint face) {
    ivec3 cell = known_voxel >> near_log2(size);
    float slot = floor(uv.x * float(NEAR_EACH));
    uint word = known_word(near_first(cell, size) + uint(slot));
    uv.x = uv.x * float(NEAR_EACH) - slot;
    voxel = near_voxel(word & NEAR_PLACE, cell, size);
    face = word >> 27 & 7u;
    return word != 0u;
}

// The voxel's face of a lamp; `way`, from 0 to 1, says how it is drawn. False if there is none. Draws a pair.
bool known_candidate(float way, inout RxSampler s, out RxLight lamp, out vec2 uv) {
    ivec3 voxel;
    if (way >= 1.0 - known_ways.w) {
        uint index;
        rx_draw_lamp(s, index, uv);
        lamp = rx_light(index);
        lamp_voxel(lamp, uv, voxel);
        lamp.voxel = voxel;
        lamp.edge = 1.0;
        return true;
    }
    uint face;
    bool found = true;
    uv = rx_next2(s);
    if (way < known_ways.x) known_draw(uv, voxel, face);
    else found = near_draw(way < known_ways.x + known_ways.y ? 0u : 1u, uv, voxel, face);
    lamp = RxLight(voxel, face, found ? rx_material(voxel) : 0u, 0.0, 1.0);
    return lamp.material != 0u;
}

struct KnownLamp {
    ivec3 voxel;
    uint face;
    float light;    // luminance that it gives, unhidden
};
KnownLamp known_chosen;

// As rx_resample_lamps, with `candidates` as the points. Draws `candidates` + 1 pairs.
RxLampSample known_resample(uint candidates, inout RxSampler s, RxRay from, vec3 normal) {
    RxLampSample chosen = RxLampSample(vec3(0.0), vec3(0.0), 0.0);
    if (rx_lights_count() == 0u) return chosen;
    vec2 first = rx_next2(s);
    float sum = 0.0, worth = 0.0, keep = first.x;
    for (uint i = 0u; i < candidates; ++i) {
        RxLight lamp;
        vec2 uv;
        if (!known_candidate((float(i) + first.y) / float(candidates), s, lamp, uv)) continue;
        RxMaterial material = rx_material_properties(lamp.material);
        bool listed;
        lamp.probability = known_density(lamp.voxel, lamp.face, material.albedo * material.emission, listed);
        RxLampSample candidate = rx_sample_lamp(lamp, uv, from, normal);
        float light = rx_luminance(candidate.light);
        if (!(light > 0.0)) continue;
        float part = rx_drawn_lamp_weight(candidate, float(candidates), normal);
        candidate.light *= part;
        float target = light * part * (listed ? 1.0 : UNKNOWN_WORTH);
        if (rx_takes(target / lamp.probability, sum, keep)) {
            chosen = candidate;
            worth = target;
            known_chosen = KnownLamp(lamp.voxel, lamp.face, light);
        }
    }
    if (worth > 0.0) chosen.light *= sum / (float(candidates) * worth);
    return chosen;
}

// As rx_met_lamp_weight, for a lamp that a ray has met.
float known_met_weight(RxHit hit, vec3 radiance, float cosine, float facing, float points) {
    bool listed;
    float density = known_density(hit.voxel, hit.face, radiance, listed);
    return rx_power_weight(max(cosine, 0.0) / RX_PI, points * density * hit.t * hit.t / max(facing, 1e-6));
}
