// Light that falls on a place of a face, by one path: from the sky, from lamps, and all that other faces send back. Needs
// <raxel/scene.glsl> and scene.glsl. Without PATH_KNOWN_LAMPS, no lamp is drawn on an instance: only rays that meet it find it. Before the include,
//
//     #define PATH_CANDIDATES n     lamps compared at the first place, 1 at the others
//     #define PATH_SUN_FIRST        also counts direct sun at the first place, which is left out otherwise
//     #define PATH_KEPT             a function `vec4 kept(RxHit hit)` knows what falls on a face without direct sun, / pi; w is 0 where not
//     #define PATH_LAMPS_APART      the lamps at the first place are compared elsewhere, and only those that a ray meets counted here
//     #define PATH_PANES n          rays go through clear bodies that are at most n voxels thick on the way; needs <raxel/light/body.glsl>
//     #define PATH_ROULETTE_FROM n  Russian roulette begins at the n-th place on the way, the third otherwise,
//     #define PATH_ROULETTE_MOST p  and lets no more than so large a part of the paths go on from each, 0.95 otherwise
//     #define PATH_DEEP n           from the n-th place on, half of the paths end at each: all wait for the longest
//     #define PATH_LAMP_LEAST x     rays to lamps whose light, unhidden, would be less than x (luminance): so many are traced as are worth x each
//     #define PATH_KNOWN_LAMPS      the lamps at the first place are drawn with the help of those that are known there: face_cache/known_lamps.glsl
//     #define PATH_LAMPS s          also sums the luminance of light from lamps: path_lamps; `s` is their share in what kept() found
//     #define PATH_PLACES n         also notes what falls on each of the first n places of the path: path_places
#ifndef LIGHT_PATH_GLSL
#define LIGHT_PATH_GLSL

#include <raxel/scene.glsl>
#include <raxel/light/lamps.glsl>
#ifdef PATH_KNOWN_LAMPS
#include "face_cache/known_lamps.glsl"
#endif

#ifndef PATH_ROULETTE_FROM
#define PATH_ROULETTE_FROM 3u
#endif
#ifndef PATH_ROULETTE_MOST
#define PATH_ROULETTE_MOST 0.95
#endif
#ifndef PATH_DEEP
#define PATH_DEEP 256u
#endif

#ifdef PATH_LAMPS_APART
const bool PATH_DRAWS_FIRST = false;
#else
const bool PATH_DRAWS_FIRST = true;
#endif

#ifdef PATH_PLACES
// A place that the path has reached.
struct PathPlace {
    RxHit at;
    vec3 falls;   // on it so far, / pi, without direct sun
    vec3 share;   // the part of the light on the path's last place that falls on this one
};
PathPlace path_places[PATH_PLACES];
uint path_reached;  // places on the path, noted or not
bool path_ended;    // by light that is kept at its last place

void path_reach(RxHit at, vec3 albedo) {
    for (uint i = 0u; i < min(path_reached, PATH_PLACES); ++i) path_places[i].share *= albedo;
    if (path_reached < PATH_PLACES) path_places[path_reached] = PathPlace(at, vec3(0.0), vec3(1.0));
    ++path_reached;
}

void path_begin(RxHit at) {
    path_reached = 0u;
    path_ended = false;
    path_reach(at, vec3(1.0));
}

// Light that falls on the path's last place counts for the first `places` of them.
void path_note(uint places, vec3 light) {
    for (uint i = 0u; i < min(places, PATH_PLACES); ++i) path_places[i].falls += path_places[i].share * light;
}

void path_live(float on) {
    for (uint i = 0u; i < min(path_reached, PATH_PLACES); ++i) path_places[i].share /= on;
}

void path_end() {
    path_ended = true;
}
#else
void path_begin(RxHit at) {}
void path_reach(RxHit at, vec3 albedo) {}
void path_note(uint places, vec3 light) {}
void path_live(float on) {}
void path_end() {}
#endif

#ifdef PATH_LAMPS
float path_lamps = 0.0;
void path_note_lamps(vec3 light, float part) {
    path_lamps += part * rx_luminance(light);
}
#else
void path_note_lamps(vec3 light, float part) {}
#endif

#ifdef PATH_KNOWN_LAMPS
// Lamps that are drawn from here on are for a place; at the first one with the help of the lists.
void path_known(ivec3 voxel, uint face, vec2 uv, bool first) {
#ifdef RX_BINDS_instances
    // Lists belong to places in the world. For a turned face, the nearest axis counts.
    vec3 away = rx_place_normal(voxel, face), most = abs(away);
    uint axis = most.x >= most.y && most.x >= most.z ? 0u : most.y >= most.z ? 1u : 2u;
    known_begin(rx_ray_from_place(voxel, face, uv, away).ray.cell, 2u * axis + (away[axis] > 0.0 ? 1u : 0u), first);
#else
    known_begin(voxel, face, first);
#endif
}
#endif

// A path on its way: the light that it has found, its last place, and the ray in work.
struct Path {
    vec3 sum;       // light found
    vec3 share;     // the part of the light on the last place that falls on the first one
    RxHit at;       // the last place
    uint depth;     // places before the last one
    bool ends;      // the cache knows the rest of the light
    RxSceneRay ray; // in work
    vec3 waiting;   // light along it, if nothing is in its way
};

// Counts a lamp that a ray meets by chance where drawing lamps would do worse, which is close to it.
void path_meet_lamp(inout Path path, RxHit hit, RxMaterial material) {
    vec3 radiance = material.albedo * material.emission;
    float points = path.depth == 0u ? float(PATH_CANDIDATES) : 1.0, facing = -dot(rx_place_normal(hit.voxel, hit.face), RX_RAY(path.ray).dir);
    float cosine = dot(rx_place_normal(path.at.voxel, path.at.face), RX_RAY(path.ray).dir), weight = rx_met_lamp_weight(radiance, cosine, facing, hit.t, points);
#ifdef PATH_KNOWN_LAMPS
    weight = known_met_weight(hit, radiance, cosine, facing, points);
    known_add(hit.voxel, hit.face, rx_luminance(radiance) * cosine * facing / (RX_PI * hit.t * hit.t));
#else
    if (rx_is_on_instance(hit.face)) weight = 1.0;
#endif
    radiance *= frame.lamp_strength * weight;
    path.sum += path.share * radiance;
    path_note_lamps(path.share * radiance, 1.0);
    path_note(path.depth + 1u, radiance);
}

// Goes on to the next place.
void path_arrive(inout Path path, RxHit hit, vec3 albedo) {
    path.at = hit;
    path.share *= albedo;
    ++path.depth;
    path_reach(hit, albedo);
#ifdef PATH_KEPT
    vec4 known = kept(hit);
    if (known.w > 0.0) {
        path.sum += path.share * known.rgb;
#ifdef PATH_LAMPS
        path_note_lamps(path.share * known.rgb, PATH_LAMPS);
#endif
        path_note(path.depth, known.rgb);
        path_end();
        path.ends = true;
    }
#endif
}

// Draws a lamp for the last place, and the ray to it.
void path_draw_lamp(inout Path path, vec3 normal, inout RxSampler numbers) {
    RxSceneRay start = rx_ray_from_place(path.at.voxel, path.at.face, path.at.uv, normal);
    RxRay from = RX_RAY(start);
    uint candidates = path.depth == 0u ? uint(PATH_CANDIDATES) : 1u;
    RxLampSample lamp = RxLampSample(vec3(0.0), vec3(0.0), 0.0);
#ifdef PATH_KNOWN_LAMPS
    path_known(path.at.voxel, path.at.face, path.at.uv, path.depth == 0u);
    lamp = known_resample(candidates, numbers, from, normal);
#else
    if (path.depth > 0u || PATH_DRAWS_FIRST) lamp = rx_resample_lamps(candidates, numbers, from, normal, float(candidates));
#endif
    path.waiting = frame.lamp_strength * lamp.light;
    path.ray = start;
#ifdef PATH_KNOWN_LAMPS
    RX_RAY(path.ray) = known_ray(from, lamp.to, known_chosen.face);
#else
    RX_RAY(path.ray) = rx_lamp_ray(from, lamp.to);
#endif
#ifdef PATH_LAMP_LEAST
    float worth = rx_luminance(path.share * path.waiting);
    if (worth < PATH_LAMP_LEAST) path.waiting *= rx_next(numbers) * PATH_LAMP_LEAST < worth ? PATH_LAMP_LEAST / worth : 0.0;
#endif
}

// Irradiance / pi, which is the light that a white matt surface would send back.
vec3 path_light(ivec3 voxel, uint face, vec2 uv, inout RxSampler numbers) {
    Path path;
    path.sum = vec3(0.0);
    path.share = vec3(1.0);
    path.at = RxHit(voxel, face, 0u, 0.0, uv, 0u);
    path.depth = 0u;
    path.ends = false;
    path.waiting = vec3(0.0);
    // Clouds shade all places of a path like the first: nearly all places are near it, and the shadows of clouds are wide.
    RxRay first = RX_RAY(rx_ray_from_place(voxel, face, uv, vec3(0.0)));
    vec3 sun = frame_sun(), sun_light = sun_irradiance(sun) * sun_through_clouds(vec3(first.cell) + first.frac);
    // Rays take turns in one loop, because each call of the tracer is compiled into the shader: at each place a ray to a lamp, one to the sun, and
    // one that goes on.
    const uint LAMP = 0u, SUN = 1u, ON = 2u;
    uint kind = ON;
    bool arrived = true;  // at a place whose light is asked for
    path_begin(path.at);
#ifdef PATH_KNOWN_LAMPS
    vec2 onward = rx_next2(numbers);   // the best of the numbers are for the first ray that goes on
#endif
    for (uint turn = 0u; turn < 256u; ++turn) {
        if (!arrived) {
            RxHit hit;
            bool found = rx_trace_places(path.ray, hit);
#ifdef PATH_PANES
            vec3 left = vec3(1.0);
            if (found && rx_pass_panes(hit, PATH_PANES, path.ray, left)) {
                if (kind == ON) path.share *= left;
                else path.waiting *= left;
                continue;
            }
#endif
            if (kind != ON) {
                bool open = !found;
#ifdef PATH_KNOWN_LAMPS
                if (kind == LAMP) open = known_reached(found, hit, known_chosen.voxel, known_chosen.face);
#endif
                if (open) {
#ifdef PATH_KNOWN_LAMPS
                    if (kind == LAMP) known_add(known_chosen.voxel, known_chosen.face, known_chosen.light);
#endif
                    path.sum += path.share * path.waiting;
                    path_note_lamps(path.share * path.waiting, kind == LAMP ? 1.0 : 0.0);
                    path_note(kind == LAMP ? path.depth + 1u : path.depth, path.waiting);
                }
            } else {
                if (!found) {
                    vec3 sky = sky_radiance(RX_RAY(path.ray).dir, sun);
                    path.sum += path.share * sky;
                    path_note(path.depth + 1u, sky);
                    break;
                }
                if (hit.face == RX_FACE_INSIDE) break;
                RxMaterial material = rx_material_properties(hit.material);
                if (material.emission > 0.0) path_meet_lamp(path, hit, material);
                path_arrive(path, hit, material.albedo);
                arrived = true;
            }
        }
        vec3 normal = rx_place_normal(path.at.voxel, path.at.face);
        if (arrived) {
            arrived = false;
            kind = LAMP;
            if (!path.ends) {
                path_draw_lamp(path, normal, numbers);
                if (path.waiting != vec3(0.0)) continue;
            }
        }
        if (kind == LAMP) {
            kind = SUN;
#ifdef PATH_SUN_FIRST
            vec3 to = rx_sun_point(sun, rx_next2(numbers));
#else
            vec3 to = path.depth > 0u ? rx_sun_point(sun, rx_next2(numbers)) : vec3(0.0);
#endif
            path.waiting = sun_light * (max(dot(normal, to), 0.0) / RX_PI);
            path.ray = rx_ray_from_place(path.at.voxel, path.at.face, path.at.uv, to);
            if (path.waiting != vec3(0.0)) continue;
        }
        if (path.ends) break;
        kind = ON;
        if (path.depth >= PATH_ROULETTE_FROM) {
            float on = min(max(path.share.x, max(path.share.y, path.share.z)), path.depth >= PATH_DEEP ? 0.5 : PATH_ROULETTE_MOST);
            if (rx_next(numbers) >= on) break;
            path.share /= on;
            path_live(on);
        }
#ifdef PATH_KNOWN_LAMPS
        if (path.depth > 0u) onward = rx_next2(numbers);
#else
        vec2 onward = rx_next2(numbers);
#endif
        path.ray = rx_ray_from_place(path.at.voxel, path.at.face, path.at.uv, rx_place_vector(path.at.voxel, path.at.face, rx_cosine_direction(RX_FACE_PART(path.at.face), onward)));
    }
    return path.sum;
}

#endif
