// Finds the first hit of each pixel. Lists the samples of this frame: those of all new faces, and of as many others, in turn, as there are
// paths for. Faces that know their light well take their turn less often. Wide ones, which many pixels show, have to know it better, and
// get more samples at once.
#version 460
#include <raxel/scene.glsl>
#include "../scene.glsl"
#include "box.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba32i) uniform writeonly iimage2D outHit;
layout(rgba32f) uniform writeonly image2D outPlace;
layout(r32ui) uniform writeonly uimage2D outSlot;
layout(rg32ui) uniform readonly uimage2D firsts;
#include "first.glsl"
#define QUEUE_ACCESS
#include "queue.glsl"
#include "../change.glsl"
#define CACHE_ACCESS
#define RX_FACE_INSERT
#include "cache.glsl"
layout(push_constant) uniform Push { float quarters; float error; int rarely; } push;
#include "across.glsl"
#include "cells.glsl"
#include "part.glsl"
#include "pick.glsl"
layout(std430) readonly buffer Stirred { uint stirred[]; };
#include "../stirred.glsl"
#ifdef RX_BINDS_Poses
#include "moves.glsl"
#endif

const float ENTRIES_MOST = 16.0;
const float KNOWN_FROM = 8.0;   // samples of a face that may wait for its turn

// The hit of a pixel's ray in the world.
bool first_of(uvec2 first, RxRay ray, out RxHit hit) {
    uint kind = first.y >> 16;
    if (kind >= FIRST_HIT) {
        hit = rx_hit_of(ray, world.origin + ivec3(first.x & 0xffffu, first.x >> 16, first.y & 0xffffu), kind - FIRST_HIT);
        return true;
    }
    hit = RxHit(ivec3(0), 0u, 0u, 0.0, vec2(0.0), 0u);
    return kind == FIRST_REST && rx_trace_from(ray, uintBitsToFloat(first.x), hit);
}

// The slot of a place, taken for it if it has none. A face without room shares the slot of a wider cell.
uint slot_at(RxHit hit, inout uint part, out RxFaceKey key) {
    for (;; part = cell_wider(hit.face, part)) {
        ivec3 cell = cell_of(hit.voxel, hit.face, part);
        key = cell_key(cell, hit.face, part);
        uint slot = cell_fits(cell, hit.face, part) ? rx_face_insert(key) : RX_NO_FACE;
        if (slot != RX_NO_FACE || part == CELL_PARTS + 4u || fit.grain < 0.0) return slot;
    }
}

// What a group of threads adds to the queue at once.
shared uint seen, wanted, listed, first_entry;

// Entries of a face that is so many pixels wide: its noise shows on all of them, and that of a narrower one on a whole pixel. `turn` is a random
// number, by which the number of entries is right in the mean.
uint entries_for(float across, float per_width, uint turn) {
#ifdef UNSOFTENED
    return 1u;
#else
    return uint(clamp(per_width * max(across, 1.0) + float(turn >> 8) / 16777216.0, 1.0, ENTRIES_MOST));
#endif
}

// Whether a shadow has moved near a face lately.
bool is_stirred(ivec3 voxel, uint face) {
    if (face >= RX_FACE_INSIDE) return false;
    for (int i = 0; i < 8; ++i) {
        uint last = stirred[stirred_place((voxel - 4 + 8 * ivec3(i & 1, i >> 1 & 1, i >> 2)) >> 3)];
        if (last != 0u && frame.index + 1u - last <= STIRRED_FRAMES) return true;
    }
    return false;
}

#ifdef RX_BINDS_Poses
// Whether an instance or its shadow has moved near a place in the world lately.
bool is_by_mover(ivec3 place) {
    // A mark lasts until each face had its turn.
    uint lasts = STIRRED_FRAMES * max(queue.every, 1u) * (uint(max(push.rarely, 16)) + 15u >> 4);
    if (last == 0u || frame.index + 1u - last > lasts) return false;
    for (uint level = 0u; level < STIRRED_LEVELS; ++level) {
        uint then = stirred[stirred_wide_place(place >> stirred_shift(level), level)];
        if (then != 0u && frame.index + 1u - then <= lasts) return true;
    }
    return false;
}
#endif

// Whether a face is listed that this frame asks for the first time, and how many entries it has. `place` is where it is in the world, `before` the frame that
// asked last, from 1 on.
bool is_listed(RxHit hit, ivec3 place, uint part, RxFaceKey key, uint slot, uint before, float height, out uint entries, out bool late) {
    float across = cell_pixels(cell_of(hit.voxel, hit.face, part), hit.face, part, height);
    if (part > 0u && part < CELL_PARTS) across *= 0.5;
    if (before == 0u) atomicAdd(fit.used, 1u);
    // Samples of light that is gone do not count.
    float samples = generation[slot] == state.generation ? light[slot].w : 0.0;
#ifdef RX_BINDS_Poses
    samples = samples_after_moves(slot, samples);
#endif
    uint own = rx_hash(key.home ^ key.rest);   // by the key, because slots depend on the order of threads
    uint turn = rx_hash(own + frame.index);
    entries = entries_for(across, samples > 0.0 ? queue.per_width : queue.per_new_width, turn);
    atomicAdd(seen, 1u);
    atomicAdd(wanted, entries_for(across, 1.0, turn));
    late = state.changed != 0u && is_stirred(hit.voxel, hit.face);
#ifdef RX_BINDS_Poses
    late = late || moves_since(slot) > 0u && is_by_mover(place);
#endif
    if (late) samples = min(samples, LATE_SAMPLES);
    float needed = queue.noise * max(across, 1.0) / (push.error * push.error);
    float wait = queue.noise > 0.0 && samples >= KNOWN_FROM ? clamp(samples / needed, 1.0, float(max(push.rarely, 1))) : 1.0;
    bool has_turn = (own + frame.index) % (max(queue.every, 1u) * uint(wait)) == 0u;
    return has_turn || samples == 0.0;
}

// The slot of a pixel's face, and how many entries of the list the face gets, if this pixel is the one that lists it.
uint see(ivec2 pixel, ivec2 size, out uint entries, out bool late) {
    late = false;
    entries = 0u;
    RxRay ray = rx_ray(frame.camera_cell, frame.camera_frac, pixel_direction(pixel, size));
    RxHit hit;
    bool found = first_of(imageLoad(firsts, pixel).xy, ray, hit);
#ifdef RX_BINDS_instances
    found = rx_trace_places_on(ray, found, hit);
#endif
    imageStore(outHit, pixel, found ? ivec4(hit.voxel, pack_hit(hit.material, hit.face)) : ivec4(0, 0, 0, -1));
    imageStore(outPlace, pixel, found ? vec4(hit.uv, hit.t, 0.0) : vec4(0.0));
    if (!found || hit.face == RX_FACE_INSIDE) return RX_NO_FACE;
    // One of 64 pixels reports how wide its face is, for the size of cells in the next frame.
    uint says = rx_hash(gl_WorkGroupID.x + rx_hash(gl_WorkGroupID.y + rx_hash(frame.index))) & FIT_APART - 1u;
    if (gl_LocalInvocationIndex == says) atomicAdd(fit.bins[fit_bin(cell_width(hit.voxel, hit.face, float(size.y)))], 1u);
    uint part = part_at(hit.voxel, hit.face, hit.uv, float(size.y), push.quarters);
    RxFaceKey key;
    uint slot = slot_at(hit, part, key);
    if (slot == RX_NO_FACE) {
        if (fit.grain >= 0.0 || rx_is_on_instance(hit.face) || rx_face_fits(hit.voxel, face_box())) atomicAdd(queue.lost, 1u);
        return slot;
    }
    if (part >= CELL_PARTS) atomicMax(queue.pick[slot], pick_rank(uint(pixel.x + pixel.y * size.x), frame.index));
    ivec3 place = frame.camera_cell + ivec3(floor(frame.camera_frac + hit.t * pixel_direction(pixel, size)));
    // Frames count from 1 here: 0 is a slot that no pass has asked for.
    uint now = frame.index + 1u, before = asked[slot] == now ? now : atomicExchange(asked[slot], now), own;
    if (before != now && is_listed(hit, place, part, key, slot, before, float(size.y), own, late)) entries = own;
    return slot;
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), size = imageSize(outHit);
    bool inside = all(lessThan(pixel, size)), leads = gl_LocalInvocationIndex == 0u;
    if (leads) {
        seen = 0u;
        wanted = 0u;
        listed = 0u;
    }
    barrier();
    bool late = false;
    uint entries = 0u, slot = RX_NO_FACE, own = 0u;
    if (inside) {
        slot = see(pixel, size, entries, late);
        imageStore(outSlot, pixel, uvec4(slot));
        if (entries > 0u) own = atomicAdd(listed, entries);
    }
    barrier();
    if (leads && seen > 0u) {
        atomicAdd(queue.seen, seen);
        atomicAdd(queue.wanted, wanted);
        first_entry = atomicAdd(queue.count, listed);
    }
    barrier();
    if (entries == 0u) return;
    // As far as there is room.
    uint first = first_entry + own, room = queue_room(size);
    entries = min(entries, room - min(first, room));
    for (uint i = 0u; i < entries; ++i) queue.faces[first + i] = queue_entry(slot, i, entries, late);
}
