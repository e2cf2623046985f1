// Measures how full the table is. After a jump of the camera, one of 64 pixels also measures how wide its face is on the picture. So the size of cells is known
// before all other pixels take slots. While the view goes on, the last frame has counted the widths (see.comp).
#version 460
#include <raxel/scene.glsl>
#include "../scene.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
#define CACHE_ACCESS
#include "cache.glsl"
#include "goes_on.glsl"
#include "queue.glsl"
layout(push_constant) uniform Push { ivec2 pixels; } push;
#include "box.glsl"
#include "across.glsl"
#include "cells.glsl"

// By the load after the last frame.
void note_load() {
    float load = float(fit.used) / float(FIT_ROOM);
    fit.pressure = load < 0.9 ? 0u : load < 1.4 ? 1u : load < 1.8 ? 2u : 3u;
    if (fit.expected <= 0.0) return;
    // More than was expected counts at once, less of it slowly.
    float crowding = float(queue.seen) / fit.expected;
    fit.crowding = clamp(max(crowding, mix(fit.crowding, crowding, 0.05)), 1.0, 16.0);
}

void main() {
    const ivec2 SIDE = ivec2(8);
    if (gl_GlobalInvocationID.xy == uvec2(0u)) note_load();
    uint pixels = uint(push.pixels.x * push.pixels.y);
    if (pixels <= FIT_ROOM || fit_goes_on(pixels)) return;
    uint own = gl_GlobalInvocationID.x + rx_hash(gl_GlobalInvocationID.y + rx_hash(frame.index)), place = rx_hash(own) & 63u;
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy) * SIDE + ivec2(place & 7u, place >> 3);
    if (any(greaterThanEqual(pixel, push.pixels))) return;
    RxHit hit;
    if (!rx_trace(rx_ray(frame.camera_cell, frame.camera_frac, pixel_direction(pixel, push.pixels)), hit) || hit.face == RX_FACE_INSIDE) return;
    atomicAdd(fit.bins[FIT_BINS + fit_bin(cell_width(hit.voxel, hit.face, float(push.pixels.y)))], 1u);
}
