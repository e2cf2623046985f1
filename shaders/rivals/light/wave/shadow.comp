// The rays that paths have asked for. One thread for both of a place, so that a pixel's light has one writer.
#version 460
#include <raxel/world.glsl>
#include <raxel/thread.glsl>
#include <raxel/light/lamps.glsl>
#include "wave.glsl"

layout(local_size_x = 64) in;
layout(std430) readonly buffer Asking { uint asking; };
layout(std430) readonly buffer Asks { Ask asks[]; };
layout(std430) buffer Light { vec4 light[]; };

void main() {
    uint i = rx_thread();
    if (i >= asking) return;
    RxRay from = rx_ray(asks[i].cell, asks[i].frac, asks[i].to_sun);
    vec3 sum = vec3(0.0);
    for (int turn = 0; turn < 2; ++turn) {
        vec3 brings = turn == 0 ? asks[i].sunlight : asks[i].lamplight;
        RxRay ray = turn == 0 ? from : rx_lamp_ray(from, asks[i].to_lamp);
        RxHit block;
        if (brings != vec3(0.0) && !rx_trace(ray, block)) sum += brings;
    }
    light[asks[i].pixel].rgb += sum;
}
