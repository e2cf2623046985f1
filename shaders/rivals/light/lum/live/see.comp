// Finds the first hit of each pixel, with details finer than a voxel: blades of grass in marked cells, and waves on water.
// A ray that passes between the blades of a cell, or over its wave, goes on behind the cell.
#version 460
#define LIVE
#include <raxel/world.glsl>
#include "light/scene.glsl"
#include "../matter.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
uniform sampler2D waves;
uniform sampler2D wind;
layout(rgba32i) uniform writeonly iimage2D outHit;
layout(rgba32f) uniform writeonly image2D outPlace;    // place on the face, distance
layout(rgba16f) uniform writeonly image2D outFine;     // normal; height on the blade, 0 to 1
layout(push_constant) uniform Push { float time; uint water; float wave_height; uint blades; } push;

const int CELLS = 24;          // that a ray may pass on its way; the next one is full

// Height of the water above the floor of its surface's cell.
float water_height(vec2 at) {
    float sum = 13.0 * textureLod(waves, at / 13.0, 0.0).x + 31.0 * textureLod(waves, at / 31.0, 0.0).y
              + 35.0 * textureLod(waves, at / 35.0, 0.0).z + 42.0 * textureLod(waves, at / 42.0, 0.0).w;
    return 1.0 - push.wave_height * (0.5 - 0.5 * sum / 60.0);
}

vec3 water_normal(vec2 at) {
    const float d = 0.35;
    return normalize(vec3(water_height(at - vec2(d, 0.0)) - water_height(at + vec2(d, 0.0)), 2.0 * d,
                          water_height(at - vec2(0.0, d)) - water_height(at + vec2(0.0, d))));
}

// The nearest blade along a ray in a cell, from `from` to `from + most * dir`. A blade is an upright triangle that the wind bends.
bool meet_blades(ivec3 cell, vec3 from, vec3 dir, float most, out float t, out vec3 normal, out float height) {
    t = RX_FAR;
    uint seed = rx_hash(cell);
    vec2 wind_here = textureLod(wind, (vec2(cell.xz) + 0.5) / 64.0, 0.0).xy;
    for (uint i = 0u; i < push.blades; ++i) {
        vec2 root = 0.1 + 0.8 * vec2(rx_random(seed), rx_random(seed));
        float tall = 0.45 + 0.5 * rx_random(seed), angle = 6.2831853 * rx_random(seed), wide = 0.09 + 0.06 * rx_random(seed);
        float own = rx_random(seed);
        vec2 lean = wind_here + 0.05 * vec2(sin(3.1 * push.time + 40.0 * own), cos(2.3 * push.time + 60.0 * own)) + 0.18 * vec2(sin(90.0 * own), cos(70.0 * own));
        // A blade does not leave its cell, where no ray looks for it.
        vec2 tip = clamp(root + lean * tall, 0.03, 0.97);
        vec3 side = vec3(cos(angle), 0.0, sin(angle)), up = vec3(tip.x - root.x, tall, tip.y - root.y) / tall;
        vec3 across = cross(side, up), start = from - vec3(root.x, 0.0, root.y);
        float slope = dot(dir, across);
        if (abs(slope) < 1e-6) continue;
        float at = -dot(start, across) / slope;
        if (at < 0.0 || at > most || at >= t) continue;
        vec3 place = start + at * dir;
        float y = place.y / tall;
        if (y < 0.0 || y > 1.0 || abs(dot(place - place.y * up, side)) > wide * (1.0 - y)) continue;
        t = at;
        height = y;
        normal = normalize(dot(across, dir) > 0.0 ? -across : across);
        // Light falls on a meadow rather than on its blades.
        normal = normalize(normal + vec3(0.0, 1.2, 0.0));
    }
    return t < RX_FAR;
}

// The surface of the water in a cell: four steps, then the crossing between the last two.
bool meet_water(ivec3 cell, vec3 from, vec3 dir, float most, out float t) {
    vec2 at = vec2(cell.xz - world.origin.xz);
    float above = from.y - water_height(at + from.xz), before = 0.0;
    t = 0.0;
    if (above <= 0.0) return true;
    for (int i = 1; i <= 4; ++i) {
        float now = most * float(i) / 4.0;
        vec3 place = from + now * dir;
        float next = place.y - water_height(at + place.xz);
        if (next <= 0.0) {
            t = mix(before, now, above / max(above - next, 1e-6));
            return true;
        }
        above = next;
        before = now;
    }
    return false;
}

// The place in a cell where a ray enters it.
vec3 entry(RxRay ray, RxHit hit) {
    if (hit.face == RX_FACE_INSIDE) return ray.frac;
    uint axis = rx_face_axis(hit.face);
    float plane = float(hit.face & 1u);
    return axis == 0u ? vec3(plane, hit.uv) : axis == 1u ? vec3(hit.uv.x, plane, hit.uv.y) : vec3(hit.uv, plane);
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), size = imageSize(outHit);
    if (any(greaterThanEqual(pixel, size))) return;
    vec3 dir = pixel_direction(pixel, size);
    RxRay ray = rx_ray(frame.camera_cell, frame.camera_frac, dir);
    ivec4 seen = ivec4(0, 0, 0, -1);
    vec4 place = vec4(0.0), fine = vec4(0.0);
    float way = 0.0;
    for (int turn = 0; turn <= CELLS; ++turn) {
        RxHit hit;
        if (!rx_trace(ray, hit)) break;
        bool grass = hit.material == GRASS_CELL;
        bool water = hit.material == push.water && (hit.face != RX_FACE_INSIDE || turn > 0) && rx_material(hit.voxel + ivec3(0, 1, 0)) != push.water;
        vec3 normal = rx_normal(hit.face), from = entry(ray, hit);
        float height = 1.0, t = 0.0;
        vec3 to_side = mix(-from, 1.0 - from, greaterThan(dir, vec3(0.0)));
        vec3 ends = mix(to_side / dir, vec3(RX_FAR), lessThan(abs(dir), vec3(1e-9)));
        float most = max(min(ends.x, min(ends.y, ends.z)), 0.0);
        bool met = true;
        if (turn == CELLS && grass) {
            normal = vec3(0.0, 1.0, 0.0);
            height = 0.3;
        } else if (grass) met = meet_blades(hit.voxel, from, dir, most, t, normal, height);
        else if (water) {
            met = meet_water(hit.voxel, from, dir, most, t);
            // The side of the lake stays flat.
            if (met && (t > 0.0 || hit.face == RX_FACE_POS_Y)) normal = water_normal(vec2(hit.voxel.xz - world.origin.xz) + from.xz + t * dir.xz);
        }
        if (met) {
            vec3 at = clamp(from + t * dir, 0.0, 1.0);
            uint face = grass || water && hit.face == RX_FACE_INSIDE ? RX_FACE_POS_Y : hit.face;
            uint axis = rx_face_axis(face);
            vec2 uv = face == RX_FACE_INSIDE || t == 0.0 && !grass ? hit.uv : axis == 0u ? at.yz : axis == 1u ? at.xz : at.xy;
            seen = ivec4(hit.voxel, pack_hit(hit.material, face));
            place = vec4(uv, way + hit.t + t, 0.0);
            fine = vec4(normal, height);
            break;
        }
        // On behind the cell.
        uint axis = ends.x <= ends.y && ends.x <= ends.z ? 0u : ends.y <= ends.z ? 1u : 2u;
        vec3 at = clamp(from + most * dir, 0.0, 1.0);
        at[axis] = dir[axis] > 0.0 ? 0.0 : 1.0;
        ray = rx_ray(hit.voxel, at, dir);
        ray.cell[axis] += dir[axis] > 0.0 ? 1 : -1;
        way += hit.t + most;
    }
    imageStore(outHit, pixel, seen);
    imageStore(outPlace, pixel, place);
    imageStore(outFine, pixel, fine);
}
