// Lamps that are known to light a place. Each cell of 16 voxels has, for each of the six directions that a face looks in, a list of voxel faces that have lit a face in it
// lately. Half of the lamps that a path compares are drawn from that list, the others by power from all lamps; each counts by the true density of both ways together, so the list adds no
// light and takes none, whatever is in it. What a list names may be gone by now: the voxel itself is asked. Needs <raxel/world.glsl>, scene.glsl and <raxel/light/lamps.glsl>.

#include "known.glsl"

const uint KNOWN_PLACE = (1u << 27) - 1u;    // of a word: the place from the middle of the cell in three bytes, the face; above it, log2 of the light
const float KNOWN_LEAST = -24.0;             // log2 of the faintest light
const float UNKNOWN_WORTH = 0.25;            // of a lamp that has not been seen yet, beside one that has

ivec3 known_corner;      // of places in the list
uint known_first;        // its first word
float known_sum;         // of the shares of all in it
float known_by_power;    // share of the lamps that are drawn by power

float known_share(uint word) {
    return word == 0u ? 0.0 : exp2(float(word >> 27));
}

void known_begin(ivec3 voxel, uint face, uint candidates) {
    ivec3 cell = voxel >> 4;
    known_corner = cell * 16 + 8 - 128;
    known_first = (rx_hash(rx_hash(cell) + face) & KNOWN_CELLS - 1u) * KNOWN_EACH;
    known_sum = 0.0;
    for (uint i = 0u; i < KNOWN_EACH / 4u; ++i) {
        uvec4 words = known[known_first / 4u + i];
        for (int k = 0; k < 4; ++k) known_sum += known_share(words[k]);
    }
    known_by_power = known_sum > 0.0 ? float((candidates + 1u) / 2u) / float(candidates) : 1.0;
}

// The place of a voxel's face in a list, or KNOWN_PLACE if it is too far away.
uint known_place(ivec3 voxel, uint face) {
    uvec3 p = uvec3(voxel - known_corner);
    return ((p.x | p.y | p.z) >> 8) != 0u ? KNOWN_PLACE : p.x | p.y << 8 | p.z << 16 | face << 24;
}

uint known_slot(uint place) {
    return known_first + (rx_hash(place) & KNOWN_EACH - 1u);
}

// How often a voxel's face, whose radiance is given, is drawn by a candidate, by area; `listed` says whether it is in the list.
float known_density(ivec3 voxel, uint face, vec3 radiance, out bool listed) {
    uint place = known_place(voxel, face), slot = known_slot(place), word = known[slot / 4u][slot % 4u];
    listed = known_sum > 0.0 && place != KNOWN_PLACE && (word & KNOWN_PLACE) == place && word != 0u;
    float by_list = listed ? (1.0 - known_by_power) * known_share(word) / known_sum : 0.0;
    return known_by_power * rx_light_probability(radiance) + by_list;
}

// A voxel's face gives a place so much light, unhidden.
void known_add(ivec3 voxel, uint face, float light) {
    uint place = known_place(voxel, face);
    if (place == KNOWN_PLACE || !(light > 0.0)) return;
    uint level = uint(clamp(log2(light) - KNOWN_LEAST, 1.0, 31.0));
    atomicMax(found[known_slot(place)], level << 27 | place);
}

// The voxel's face that a place on a lamp lies on, and the place there.
void known_point(RxLight lamp, inout vec2 uv, out ivec3 voxel) {
    ivec3 u, v;
    rx_face_tangents(lamp.face, u, v);
    vec2 whole = min(floor(uv * lamp.edge), lamp.edge - 1.0);
    uv = uv * lamp.edge - whole;
    voxel = lamp.voxel + int(whole.x) * u + int(whole.y) * v;
    // A large face lies on the far side of its cell.
    if ((lamp.face & 1u) != 0u) voxel += (int(lamp.edge) - 1) * rx_face_step(lamp.face);
}

// A face of the list, drawn by its share. Draws a pair.
void known_draw(inout RxSampler s, out ivec3 voxel, out uint face, out vec2 uv) {
    uv = rx_next2(s);
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
    float sum = 0.0, worth = 0.0, keep = rx_next(s);
    uint by_list = known_sum > 0.0 ? candidates / 2u : 0u;
    for (uint i = 0u; i < candidates; ++i) {
        RxLight lamp;
        vec2 uv;
        ivec3 voxel;
        if (i < by_list) {
            uint face;
            known_draw(s, voxel, face, uv);
            lamp = RxLight(voxel, face, rx_material(voxel), 0.0, 1.0);
            if (lamp.material == 0u) continue;
        } else {
            uint index;
            rx_draw_lamp(s, index, uv);
            lamp = rx_light(index);
            known_point(lamp, uv, voxel);
            lamp.voxel = voxel;
            lamp.edge = 1.0;
        }
        RxMaterial material = rx_material_properties(lamp.material);
        bool listed;
        lamp.probability = known_density(voxel, lamp.face, material.albedo * material.emission, listed);
        RxLampSample candidate = rx_sample_lamp(lamp, uv, from, normal);
        float light = rx_luminance(candidate.light);
        if (!(light > 0.0)) continue;
        float part = rx_drawn_lamp_weight(candidate, float(candidates), normal);
        candidate.light *= part;
        float target = light * part * (listed ? 1.0 : UNKNOWN_WORTH);
        if (rx_takes(target / lamp.probability, sum, keep)) {
            chosen = candidate;
            worth = target;
            known_chosen = KnownLamp(voxel, lamp.face, light);
        }
    }
    if (worth > 0.0) chosen.light *= sum / (float(candidates) * worth);
    return chosen;
}

// As rx_met_lamp_weight, for a lamp that the first ray of a path has met.
float known_met_weight(RxHit hit, vec3 radiance, float cosine, float facing, float points) {
    bool listed;
    float density = known_density(hit.voxel, hit.face, radiance, listed);
    return rx_power_weight(max(cosine, 0.0) / RX_PI, points * density * hit.t * hit.t / max(facing, 1e-6));
}
