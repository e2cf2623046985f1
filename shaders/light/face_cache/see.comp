// Finds the first hit of each pixel. Lists the faces that get new samples, each once: all new faces, and as many
// others, in turn, as there are paths for. Faces that know their light well take their turn less often; wide ones,
// which many pixels show, have to know it better.
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
#ifdef RX_BINDS_Poses
#include "moves.glsl"
#endif

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

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), size = imageSize(outHit);
    if (any(greaterThanEqual(pixel, size))) return;
    RxRay ray = rx_ray(frame.camera_cell, frame.camera_frac, pixel_direction(pixel, size));
    RxHit hit;
    bool found = first_of(imageLoad(firsts, pixel).xy, ray, hit);
#ifdef RX_BINDS_instances
    found = rx_trace_places_on(ray, found, hit);
#endif
    imageStore(outHit, pixel, found ? ivec4(hit.voxel, pack_hit(hit.material, hit.face)) : ivec4(0, 0, 0, -1));
    imageStore(outPlace, pixel, found ? vec4(hit.uv, hit.t, 0.0) : vec4(0.0));
    uint slot = RX_NO_FACE;
    if (found && hit.face != RX_FACE_INSIDE) {
        // One of 64 pixels reports how wide its face is, for the size of cells in the next frame.
        uint says = rx_hash(gl_WorkGroupID.x + rx_hash(gl_WorkGroupID.y + rx_hash(frame.index))) & FIT_APART - 1u;
        if (gl_LocalInvocationIndex == says) atomicAdd(fit.bins[fit_bin(cell_width(hit.voxel, hit.face, float(size.y)))], 1u);
        uint part = part_at(hit.voxel, hit.face, hit.uv, float(size.y), push.quarters);
        RxFaceKey key;
        slot = slot_at(hit, part, key);
        if (slot == RX_NO_FACE && (fit.grain >= 0.0 || rx_is_on_instance(hit.face) || rx_face_fits(hit.voxel, face_box()))) atomicAdd(queue.lost, 1u);
        if (slot != RX_NO_FACE && part >= CELL_PARTS) atomicMax(queue.pick[slot], pick_rank(uint(pixel.x + pixel.y * size.x), frame.index));
        // Frames count from 1 here: 0 is a slot that no pass has asked for. The list holds as many faces as there are pixels.
        uint now = frame.index + 1u, before = slot == RX_NO_FACE || asked[slot] == now ? now : atomicExchange(asked[slot], now);
        if (before != now) {
            atomicAdd(queue.seen, 1u);
            if (before == 0u) atomicAdd(fit.used, 1u);
            // Samples of light that is gone do not count.
            float samples = generation[slot] == state.generation ? light[slot].w : 0.0;
#ifdef RX_BINDS_Poses
            samples = samples_after_moves(slot, samples);
#endif
            float across = cell_pixels(cell_of(hit.voxel, hit.face, part), hit.face, part, float(size.y));
            float needed = queue.noise * max(part == 0u || part >= CELL_PARTS ? across : 0.5 * across, 1.0) / (push.error * push.error);
            float wait = queue.noise > 0.0 ? clamp(samples / needed, 1.0, float(max(push.rarely, 1))) : 1.0;
            // By the key, because slots depend on the order of threads.
            bool turn = (rx_hash(key.home ^ key.rest) + frame.index) % (max(queue.every, 1u) * uint(wait)) == 0u;
            if (turn || samples == 0.0) queue.faces[atomicAdd(queue.count, 1u)] = slot;
        }
    }
    imageStore(outSlot, pixel, uvec4(slot));
}
