// A grid of probes over the world (Majercik et al., "Dynamic diffuse global illumination with ray-traced irradiance fields", 2019). Voxel faces
// look in six directions only, so a probe keeps irradiance for these six, exactly, and an octahedral map only for distances.

layout(std140) uniform Grid {
    ivec3 world_min;
    ivec3 world_max;
} grid;

const int PROBE_SPACING = 16;
const int PROBE_RAYS = 32;
const int DEPTH_SIDE = 8;
const float PROBE_FAR = 2.0 * 16.0;   // distances beyond it are all the same to a test of visibility

#ifndef PROBE_ACCESS
#define PROBE_ACCESS readonly
#endif
layout(std430) PROBE_ACCESS buffer Probes { vec4 probes[]; };   // irradiance / pi, frames; six each
layout(std430) PROBE_ACCESS buffer Depths { vec2 depths[]; };   // mean and mean square; 64 each

ivec3 probe_counts() {
    return max((grid.world_max - grid.world_min + PROBE_SPACING - 1) / PROBE_SPACING, ivec3(1));
}

// A probe stands at the centre of its cube of 16 voxels.
ivec3 probe_of(int index) {
    ivec3 n = probe_counts();
    return ivec3(index % n.x, index / n.x % n.y, index / (n.x * n.y));
}

int probe_index(ivec3 probe) {
    ivec3 n = probe_counts();
    return probe.x + n.x * (probe.y + n.y * probe.z);
}

vec3 depth_direction(int texel) {
    vec2 p = (vec2(texel % DEPTH_SIDE, texel / DEPTH_SIDE) + 0.5) / float(DEPTH_SIDE) * 2.0 - 1.0;
    vec3 d = vec3(p, 1.0 - abs(p.x) - abs(p.y));
    if (d.z < 0.0) d.xy = (1.0 - abs(d.yx)) * vec2(d.x >= 0.0 ? 1.0 : -1.0, d.y >= 0.0 ? 1.0 : -1.0);
    return normalize(d);
}

vec2 depth_towards(int probe, vec3 d) {
    d /= abs(d.x) + abs(d.y) + abs(d.z);
    if (d.z < 0.0) d.xy = (1.0 - abs(d.yx)) * vec2(d.x >= 0.0 ? 1.0 : -1.0, d.y >= 0.0 ? 1.0 : -1.0);
    vec2 place = clamp((d.xy * 0.5 + 0.5) * float(DEPTH_SIDE) - 0.5, 0.0, float(DEPTH_SIDE) - 1.001);
    ivec2 base = ivec2(place);
    vec2 part = place - vec2(base);
    int at = 64 * probe + base.x + DEPTH_SIDE * base.y;
    return mix(mix(depths[at], depths[at + 1], part.x), mix(depths[at + DEPTH_SIDE], depths[at + DEPTH_SIDE + 1], part.x), part.y);
}

// Irradiance / pi at a place of a face, from the eight probes around it. `cell` and `frac` are where a ray that leaves the face starts.
vec3 probe_light(ivec3 cell, vec3 frac, uint face) {
    vec3 normal = rx_normal(face);
    // From the centre of the first probe, in steps of the grid; a little away from the face.
    vec3 place = (vec3(cell - grid.world_min) + frac + 0.5 * normal) / float(PROBE_SPACING) - 0.5;
    ivec3 base = ivec3(floor(place)), last = probe_counts() - 1;
    vec3 part = place - vec3(base), sum = vec3(0.0);
    float weight = 0.0;
    for (int i = 0; i < 8; ++i) {
        ivec3 step = ivec3(i & 1, i >> 1 & 1, i >> 2), probe = clamp(base + step, ivec3(0), last);
        int index = probe_index(probe);
        vec4 light = probes[6 * index + int(face)];
        if (light.w == 0.0) continue;
        vec3 way = (vec3(probe) - place) * float(PROBE_SPACING);
        float distance = max(length(way), 1e-3);
        vec3 along = mix(1.0 - part, part, vec3(step));
        float w = max(along.x * along.y * along.z, 1e-4);
        // Probes behind the face count less. Probes that do not see it hardly count (Chebyshev's inequality).
        float facing = 0.5 + 0.5 * dot(way / distance, normal);
        w *= facing * facing + 0.2;
        vec2 depth = depth_towards(index, -way / distance);
        if (distance > depth.x) {
            float variance = max(depth.y - depth.x * depth.x, 0.05), beyond = distance - depth.x;
            float seen = variance / (variance + beyond * beyond);
            w *= max(seen * seen * seen, 1e-3);
        }
        sum += w * light.rgb;
        weight += w;
    }
    return weight > 0.0 ? sum / weight : vec3(0.0);
}

// The same turn for all probes of a frame, and the directions of Fibonacci's spiral (Keinert et al. 2015).
vec3 ray_direction(int i, uint index) {
    uint seed = scene_seed(rx_hash(index + 17u));
    vec3 z = rx_random_direction(seed), x, y;
    rx_basis(z, x, y);
    float height = 1.0 - (2.0 * float(i) + 1.0) / float(PROBE_RAYS);
    float angle = 2.0 * RX_PI * (fract(float(i) * 0.618033988749895) + rx_random(seed));
    float r = sqrt(1.0 - height * height);
    return r * cos(angle) * x + r * sin(angle) * y + height * z;
}
