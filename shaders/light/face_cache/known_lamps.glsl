// Lamps that are known to light a place. Each cell of 16 voxels has a list for each of the six directions of faces: the voxel faces
// that lately lit such a face in the cell. Regions of 64 and of 256 voxels have wider lists of voxel faces that lit anything in
// them, so that all faces around share their lamps. A path draws lamps from all three lists, and the others by power from all lamps.
// Those on instances are drawn by power alone, and no list has them. Each counts by the true density of all ways together, so the
// lists add no light and take none, for any contents. A listed lamp may be gone by now: the voxel itself is asked. Needs
// <raxel/scene.glsl>, scene.glsl and <raxel/light/lamps.glsl>.
#include "known.glsl"
#ifdef RX_BINDS_instances
#include "instance_lamps.glsl"
#endif

const uint KNOWN_PLACE = (1u << KNOWN_BITS) - 1u;    // the place from the centre of the cell in three bytes, the face
const uint REGION_PLACE = (1u << REGION_BITS) - 1u;  // the place in three times 9 bits, the face
const uint REGION_LATELY = 3u << REGION_BITS;
const float KNOWN_LEAST = -24.0;             // log2 of the faintest light
const float UNKNOWN_WORTH = 0.25;            // of a lamp that is in no list, beside one that is

ivec3 known_voxel;       // the place
uint known_first;        // the first word of its list
float known_sum;         // of the shares of all in it
uvec2 known_members;     // of the lists of its regions
vec4 known_ways;         // shares of the lamps that are drawn from the list, from those of the two regions, and by power
float known_moving;      // share of those on instances, which no list has, of all lamps

uint known_word(uint at) {
    return known[at / 4u][at % 4u];
}

float known_share(uint word) {
    return word == 0u ? 0.0 : exp2(float(word >> KNOWN_BITS));
}

// The corner of places in the list of a cell.
ivec3 known_corner() {
    return (known_voxel >> 4) * 16 + 8 - 128;
}

int region_log2(uint size) {
    return size == 0u ? 6 : 8;
}

// The same of the list of a region: 512 voxels around its centre.
ivec3 region_corner(uint size) {
    int log2_width = region_log2(size);
    return (known_voxel >> log2_width << log2_width) + (1 << log2_width - 1) - 256;
}

// The index of a region's list among those of its size.
uint region_list(uint size) {
    return (size * REGION_CELLS + (rx_hash(rx_hash(known_voxel >> region_log2(size)) + size) & REGION_CELLS - 1u)) * REGION_EACH;
}

// Before lamps are drawn for a place. Without `lists`, all are drawn by power.
void known_begin(ivec3 voxel, uint face, bool lists) {
    known_voxel = voxel;
    known_first = (rx_hash(rx_hash(voxel >> 4) + face) & KNOWN_CELLS - 1u) * KNOWN_EACH;
    known_sum = 0.0;
#ifdef RX_BINDS_instances
    // No list has a lamp on an instance.
    lists = lists && rx_lights_count() > 0u;
#endif
    for (uint i = 0u; i < KNOWN_EACH / 4u && lists; ++i) {
        uvec4 words = known[known_first / 4u + i];
        for (int k = 0; k < 4; ++k) known_sum += known_share(words[k]);
    }
    known_members = uvec2(0u);
    for (uint size = 0u; size < REGION_SIZES && lists; ++size) known_members[size] = known[(REGION_ROWS + region_list(size)) / 4u].x;
    known_ways = vec4(known_sum > 0.0 ? 0.5 : 0.0, known_members.x > 0u ? 0.25 : 0.0, known_members.y > 0u ? 0.125 : 0.0, 0.125);
    known_ways /= known_ways.x + known_ways.y + known_ways.z + known_ways.w;
    known_moving = 0.0;
#ifdef RX_BINDS_instances
    if (instances.lamps > 0u) known_moving = rx_lights_count() > 0u ? 0.25 : 1.0;
#endif
}

// The place of a voxel's face in a list, or KNOWN_PLACE if it is too far away.
uint known_place(ivec3 voxel, uint face) {
    uvec3 p = uvec3(voxel - known_corner());
    return ((p.x | p.y | p.z) >> 8) != 0u ? KNOWN_PLACE : p.x | p.y << 8 | p.z << 16 | face << 24;
}

uint known_slot(uint place) {
    return known_first + (rx_hash(place) & KNOWN_EACH - 1u);
}

// The same in that of a region.
uint region_place(ivec3 voxel, uint face, uint size) {
    uvec3 p = uvec3(voxel - region_corner(size));
    return ((p.x | p.y | p.z) >> 9) != 0u ? REGION_PLACE : p.x | p.y << 9 | p.z << 18 | face << 27;
}

uint region_slot(uint place, uint size) {
    return REGION_SETS + region_list(size) + (rx_hash(place) & REGION_EACH - 1u);
}

// The density by area with which a candidate draws a voxel's face of this radiance. `listed` is true if a list has it.
float known_density(ivec3 voxel, uint face, vec3 radiance, out bool listed) {
#ifdef RX_BINDS_instances
    listed = rx_is_on_instance(face);
    if (listed) return known_moving * instance_lamp_probability(radiance);
#endif
    listed = false;
    float density = known_ways.w * rx_light_probability(radiance);
    if (known_ways.x > 0.0) {
        uint place = known_place(voxel, face), word = known_word(known_slot(place));
        if (place != KNOWN_PLACE && (word & KNOWN_PLACE) == place && word != 0u) {
            listed = true;
            density += known_ways.x * known_share(word) / known_sum;
        }
    }
    for (uint size = 0u; size < REGION_SIZES; ++size) {
        if (known_members[size] == 0u) continue;
        uint place = region_place(voxel, face, size), word = known_word(region_slot(place, size));
        if (place != REGION_PLACE && (word & REGION_PLACE) == place && word != 0u) {
            listed = true;
            density += known_ways[size + 1u] / float(known_members[size]);
        }
    }
#ifdef RX_BINDS_instances
    density *= 1.0 - known_moving;
#endif
    return density;
}

// Most threads of a frame bring a lamp that another one has brought.
void known_bring(uint at, uint word) {
    if (found[at] < word) atomicMax(found[at], word);
}

// A voxel's face gives a place this much light, unhidden.
void known_add(ivec3 voxel, uint face, float light) {
    if (!(light > 0.0) || rx_is_on_instance(face)) return;
    uint place = known_place(voxel, face), level = uint(clamp(log2(light) - KNOWN_LEAST, 1.0, 31.0));
    if (place != KNOWN_PLACE) known_bring(known_slot(place), level << KNOWN_BITS | place);
    for (uint size = 0u; size < REGION_SIZES; ++size) {
        place = region_place(voxel, face, size);
        if (place != REGION_PLACE) known_bring(region_slot(place, size), REGION_LATELY | place);
    }
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
            // The rest of the number is the place on the face.
            uv.x = min(left / share, 0.99999994);
            done = left < share;
            left -= share;
        }
    }
    voxel = known_corner() + ivec3(uvec3(chosen, chosen >> 8, chosen >> 16) & 255u);
    face = chosen >> 24 & 7u;
}

// The same from the list of a region, each member alike.
void region_draw(uint size, inout vec2 uv, out ivec3 voxel, out uint face) {
    float members = float(known_members[size]), chosen = min(floor(uv.x * members), members - 1.0);
    uint word = known_word(REGION_ROWS + region_list(size) + 1u + uint(chosen));
    uv.x = clamp(uv.x * members - chosen, 0.0, 0.99999994);
    voxel = region_corner(size) + ivec3(uvec3(word, word >> 9, word >> 18) & 511u);
    face = word >> 27 & 7u;
}

// The voxel's face of a lamp; `way`, from 0 to 1, chooses how it is drawn. False if it is gone. Draws a pair.
bool known_candidate(float way, inout RxSampler s, out RxLight lamp, out vec2 uv) {
#ifdef RX_BINDS_instances
    if (way < known_moving) {
        lamp = draw_instance_lamp(s, uv);
        return true;
    }
    way = (way - known_moving) / (1.0 - known_moving);
#endif
    float by_lists = 1.0 - known_ways.w;
    if (way >= by_lists) {
        uint index;
        rx_draw_lamp(s, index, uv);
        lamp = rx_light(index);
        known_point(lamp, uv, lamp.voxel);
        lamp.edge = 1.0;
        return true;
    }
    ivec3 voxel;
    uint face;
    uv = rx_next2(s);
    if (way < known_ways.x) known_draw(uv, voxel, face);
    else region_draw(known_members.x > 0u && (way < known_ways.x + known_ways.y || known_members.y == 0u) ? 0u : 1u, uv, voxel, face);
    lamp = RxLight(voxel, face, rx_material(voxel), 0.0, 1.0);
    return lamp.material != 0u;
}

// The ray that looks whether a lamp is hidden. On an instance it must meet the lamp, because a wall may lie in the same plane; else it ends just before it.
RxRay known_ray(RxRay from, vec3 to, uint face) {
    RxRay ray = rx_lamp_ray(from, to);
    if (rx_is_on_instance(face)) ray.t_max = 1.0001;
    return ray;
}

// Whether that ray has come to its lamp.
bool known_reached(bool found, RxHit hit, ivec3 voxel, uint face) {
    return rx_is_on_instance(face) ? found && hit.voxel == voxel && hit.face == face : !found;
}

struct KnownLamp {
    ivec3 voxel;
    uint face;
    float light;    // luminance that it gives, unhidden
};
KnownLamp known_chosen;

// The point of a candidate, from a point in a cell, and the lamp's normal there.
vec3 known_to(RxLight lamp, vec2 uv, ivec3 cell, vec3 frac, out vec3 normal) {
#ifdef RX_BINDS_instances
    if (rx_is_on_instance(lamp.face)) return instance_lamp_to(lamp, uv, cell, frac, normal);
#endif
    normal = rx_normal(lamp.face);
    return rx_to_light(lamp, uv, cell, frac);
}

// As rx_resample_lamps, with `candidates` as the points. Draws `candidates` + 1 pairs.
RxLampSample known_resample(uint candidates, inout RxSampler s, RxRay from, vec3 normal) {
    RxLampSample chosen = RxLampSample(vec3(0.0), vec3(0.0), 0.0);
    if (rx_lights_count() == 0u && known_moving == 0.0) return chosen;
    vec2 first = rx_next2(s);
    float sum = 0.0, worth = 0.0, keep = first.x;
    for (uint i = 0u; i < candidates; ++i) {
        RxLight lamp;
        vec2 uv;
        if (!known_candidate((float(i) + first.y) / float(candidates), s, lamp, uv)) continue;
        RxMaterial material = rx_material_properties(lamp.material);
        bool listed;
        lamp.probability = known_density(lamp.voxel, lamp.face, material.albedo * material.emission, listed);
        vec3 lamp_normal, to = known_to(lamp, uv, from.cell, from.frac, lamp_normal);
        RxLampSample candidate = rx_lamp_sample(to, lamp_normal, material, lamp.probability, normal);
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
