// Traces a path for each entry of the list, from a random place on its face, or for a cell from a place that a pixel sees. It finds skylight, lamps and all light that
// other faces send back, without direct sun. At a face that keeps light itself, the path ends and takes that light. Only data of the last frame
// is read, so the order of threads does not matter.
#version 460
#include <raxel/scene.glsl>
#include <raxel/thread.glsl>
#include "../scene.glsl"
#include "box.glsl"

layout(local_size_x = 64) in;
#include "queue.glsl"
#include "../change.glsl"
#include "cache.glsl"
layout(std430) writeonly buffer Fresh { vec4 fresh[]; };
layout(rgba32i) uniform readonly iimage2D hits;
layout(push_constant) uniform Push { ivec2 pixels; int ready; int candidates; float quarters; } push;
#include "across.glsl"
#include "cells.glsl"
#include "part.glsl"
#include "pick.glsl"
#ifdef RX_BINDS_instances
#include "moves.glsl"
#define PATH_LAMPS kept_lamps
float kept_lamps;   // the share of lamps in the light that kept() found last
#endif

// Light that a face keeps, as one value, in quarters, or as a part of a cell. Light from before the change is not passed on.
vec4 kept(RxHit hit) {
    uint part = part_at(hit.voxel, hit.face, hit.uv, float(push.pixels.y), push.quarters);
    ivec3 cell = cell_of(hit.voxel, hit.face, part);
    if (!cell_fits(cell, hit.face, part)) return vec4(0.0);
    uint slot = rx_face_find(cell_key(cell, hit.face, part));
    if (slot == RX_NO_FACE || generation[slot] != state.generation || light[slot].w < float(push.ready)) return vec4(0.0);
#ifdef PATH_LAMPS
    kept_lamps = moves_lamps(moves_seen[slot]);
#endif
    return light[slot];
}

#ifdef PATH_PANES
#include <raxel/light/body.glsl>
#endif
#ifdef SHORT_PATHS
// All wait for the longest path. If samples have little noise, half of the paths that have met no face with known light end at each place. In worlds
// without lamps, at least a quarter end, and more where surfaces are dark.
#define PATH_ROULETTE_FROM (queue_quiet() || queue_even() ? 1u : 3u)
#define PATH_ROULETTE_MOST (queue_quiet() ? 0.5 : queue_even() ? 0.75 : 0.95)
#endif
#define PATH_DEEP 5u
// A lamp far away is worth a ray now and then: in daylight, or among thousands of others.
#define PATH_LAMP_LEAST (0.3 * queue.bright)
#define PATH_KEPT
#ifdef RX_BINDS_Known
#define PATH_KNOWN_LAMPS
#endif
#define PATH_CANDIDATES push.candidates
#include "../path.glsl"

void main() {
    uint i = rx_thread();
    if (i >= queue.count) return;
    RxFaceKey key;
    uint entry = queue.faces[i], slot = entry_slot(entry);
    if (!rx_face_in_slot(slot, key)) return;
    ivec3 voxel;
    uint face, part;
    cell_of_key(key, voxel, face, part);
    // Each count of entries has a sequence of its own: in one sequence, a face whose count changes would take numbers twice.
    uint entries = entries_of_face(entry);
    RxSampler numbers = rx_sampler(frame.index * entries + entry_number(entry), scene_seed(rx_hash(key.home + entries) ^ key.rest));
    vec3 corner = vec3(0.0, 0.0, 1.0);
    if (part < CELL_PARTS) {
        corner = rx_face_part(part);
    } else {
        uint pixel = pick_pixel(queue.pick[slot], frame.index);
        voxel = imageLoad(hits, ivec2(pixel % uint(push.pixels.x), pixel / uint(push.pixels.x))).xyz;
    }
    vec2 uv = corner.xy + corner.z * rx_next2(numbers);
    vec3 found = path_light(voxel, face, uv, numbers);
#ifdef PATH_LAMPS
    fresh[i] = vec4(found, path_lamps);
#else
    fresh[i] = vec4(found, 0.0);
#endif
}
