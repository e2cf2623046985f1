// Enters lamps into the lists of the cells around them (near_lamps.glsl): an eighth of all lamps in each frame. Of those that want one place in a list, a strong one stays, or else
// a random one.
#version 460
#include <raxel/ray.glsl>
#include <raxel/random.glsl>
#include "../frame.glsl"

layout(local_size_x = 64) in;
layout(std430) buffer Found { uint found[]; };
#include <raxel/light/lights.glsl>
#include "near_lamps.glsl"
#include "lamp_voxel.glsl"

// From 1 to 3, beside the mean lamp.
uint strength(RxLight lamp) {
    float part = lamp.probability * lamp.edge * lamp.edge * float(rx_lights_count());
    return part < 0.5 ? 1u : part < 4.0 ? 2u : 3u;
}

void main() {
    uint index = gl_GlobalInvocationID.x * NEAR_TURNS + frame.index % NEAR_TURNS, turn = frame.index / NEAR_TURNS;
    if (index >= rx_lights_count()) return;
    RxLight lamp = rx_light(index);
    uint state = rx_hash(index ^ rx_hash(turn));
    vec2 uv = vec2(rx_random(state), rx_random(state));
    ivec3 voxel;
    lamp_voxel(lamp, uv, voxel);
    uint axis = rx_face_axis(lamp.face), word = strength(lamp) << 30;
    int ahead = (lamp.face & 1u) != 0u ? 1 : -1;
    for (uint size = 0u; size < NEAR_SIZES; ++size) {
        ivec3 own = voxel >> near_log2(size), away = abs(own - (frame.camera_cell >> near_log2(size)));
        if (any(greaterThan(away, ivec3(NEAR_REACH)))) continue;
        for (int i = 0; i < 27; ++i) {
            ivec3 step = ivec3(i % 3, i / 3 % 3, i / 9) - 1;
            if (step[axis] * ahead < 0) continue;   // it faces away
            uint place = near_place(voxel, lamp.face, own + step, size);
            atomicMax(found[near_first(own + step, size) + near_slot(place)], word | near_mixed(place, turn));
        }
    }
}
