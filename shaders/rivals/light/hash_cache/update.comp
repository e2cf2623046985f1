// A path from a random pixel of each tile. The light on each of its first places goes into the cells there, and a cell that has light
// already ends it. Sums are of whole numbers, so the order of threads does not matter.
#version 460
#include <raxel/world.glsl>
#include <raxel/thread.glsl>
#include "light/scene.glsl"

layout(local_size_x = 64) in;
layout(rgba32i) uniform readonly iimage2D hits;
layout(rgba32f) uniform readonly image2D places;
#define QUEUE_ACCESS
#include "light/face_cache/queue.glsl"
#include "light/change.glsl"
#define RX_FACE_INSERT
#define CACHE_ACCESS
#include "light/face_cache/cache.glsl"
#include "sums.glsl"
layout(push_constant) uniform Push { int candidates; int ready; float cell; int tile; } push;
#include "kept.glsl"

#define PATH_CANDIDATES push.candidates
#define PATH_PLACES 4u
#include "light/path.glsl"

void add(RxHit at, vec3 falls) {
    uint level = cell_level(at.voxel, push.cell, float(imageSize(hits).y));
    if (!cell_fits(at.voxel, at.face, level)) return;
    uint slot = rx_face_insert(cell_key(at.voxel, at.face, level));
    if (slot == RX_NO_FACE) {
        atomicAdd(queue.lost, 1u);
        return;
    }
    sums_add(slot, falls);
    uint now = frame.index + 1u;
    if (asked[slot] != now && atomicExchange(asked[slot], now) != now) queue.faces[atomicAdd(queue.count, 1u)] = slot;
}

void main() {
    uint i = rx_thread();
    if (i >= queue.work) return;
    ivec2 size = imageSize(hits);
    uint tile = uint(push.tile), across = (uint(size.x) + tile - 1u) / tile;
    uvec2 corner = tile * uvec2(i % across, i / across);
    RxSampler numbers = rx_sampler(frame.index, scene_seed(i + 0x5bd1e995u));
    uvec2 within = min(uvec2(rx_next2(numbers) * float(tile)), uvec2(tile - 1u));
    ivec2 pixel = min(ivec2(corner + within), size - 1);
    ivec4 hit = imageLoad(hits, pixel);
    if (hit.w < 0 || hit_face(hit.w) == RX_FACE_INSIDE) return;
    path_light(hit.xyz, hit_face(hit.w), imageLoad(places, pixel).xy, numbers);
    // The place where kept light has ended the path has nothing to add to it.
    uint count = min(path_ended ? path_reached - 1u : path_reached, PATH_PLACES);
    for (uint place = 0u; place < count; ++place) add(path_places[place].at, path_places[place].falls);
}
