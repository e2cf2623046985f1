// Keeps the poses of instances in this frame and the last one, for moved.glsl and face_cache/moves.glsl. Counts moved instances, so the count changes
// after each frame with a move. Notes the count when a lamp goes far in a frame. Marks the surroundings of each moved instance and the way of its shadow
// (stirred.glsl).
#version 460
#include <raxel/instance_frame.glsl>
#include "scene.glsl"

layout(local_size_x = 64) in;
// For each instance the eight quads of the last frame, then those of this one.
layout(std430) buffer Poses { uint moves; uint leaps; uint last; uint unused; uvec4 poses[]; };
layout(std430) buffer Stirred { uint stirred[]; };
#include "stirred.glsl"

const uint QUADS = RX_INSTANCE_QUADS;
const float LEAP = 1.0;         // voxels in a frame
const float SURROUNDS = 2.0;    // radii of an instance: farther away, it hides little
const float BESIDE = 4.0;       // voxels beside a shadow that its light reaches
const float CELLS_ACROSS = 4.0;
const int SHADOW_CELLS = 16;    // in which the shadow of an instance is followed

// About the distance that the farthest voxel of an instance has gone.
float way(RxInstance was, RxInstance now) {
    vec3 step = vec3(now.cell - was.cell) + (vec3(now.fraction) - vec3(was.fraction)) / 16777216.0;
    ivec3 turn = max(max(abs(now.row_x - was.row_x), abs(now.row_y - was.row_y)), abs(now.row_z - was.row_z));
    vec3 size = vec3(now.high - now.low);
    bool other = was.shape != now.shape;
    return length(step) + (other ? 1.0 : float(max(turn.x, max(turn.y, turn.z))) / 8388608.0) * max(size.x, max(size.y, size.z));
}

// Marks the cells around a place.
void stir_around(ivec3 from, vec3 place, float reach, uint level) {
    uint shift = stirred_shift(level);
    ivec3 first = from + ivec3(floor(place - reach)) >> shift, end = from + ivec3(floor(place + reach)) >> shift;
    for (int z = first.z; z <= end.z; ++z) {
        for (int y = first.y; y <= end.y; ++y) {
            for (int x = first.x; x <= end.x; ++x) stirred[stirred_wide_place(ivec3(x, y, z), level)] = frame.index + 1u;
        }
    }
}

// Marks what is around an instance, and where its shadow may fall.
void stir(RxInstance instance) {
    vec3 middle = 0.5 * vec3(instance.low + instance.high);
    float radius = 0.5 * length(vec3(instance.high - instance.low)) + 1.0;
    ivec3 from = instance.corner;
    if (rx_instance_is_free(instance)) {
        from = instance.cell;
        middle = rx_direction_from_instance(instance, vec3(instance.corner) + middle) + vec3(instance.fraction) / 16777216.0;
    }
    uint level = 0u;
    while (level + 1u < STIRRED_LEVELS && 2.0 * SURROUNDS * radius > CELLS_ACROSS * float(1u << stirred_shift(level))) ++level;
    // A larger instance stirs no more than this around its middle.
    float cell = float(1u << stirred_shift(level)), most = CELLS_ACROSS * cell;
    stir_around(from, middle, min(SURROUNDS * radius, most), level);
    if (frame.sun_strength <= 0.0) return;
    vec3 on = -cell * frame_sun();
    for (int i = 1; i <= SHADOW_CELLS; ++i) stir_around(from, middle + float(i) * on, min(radius + BESIDE, most), level);
}

void main() {
    uint index = gl_GlobalInvocationID.x;
    if (index >= instances.count) return;
    uint at = 2u * QUADS * index;
    bool moved = false, known = false;
    uvec4 before[QUADS], after[QUADS];
    for (uint i = 0u; i < QUADS; ++i) {
        uvec4 was = poses[at + QUADS + i], now = instances.quads[instances.first + QUADS * index + i];
        before[i] = was;
        after[i] = now;
        known = known || was != uvec4(0u);
        moved = moved || was != now;
        poses[at + i] = was;
        poses[at + QUADS + i] = now;
    }
    // A new instance has no earlier pose.
    if (!known) {
        for (uint i = 0u; i < QUADS; ++i) poses[at + i] = poses[at + QUADS + i];
    }
    if (!moved) return;
    uint move = atomicAdd(moves, 1u) + 1u;
    last = frame.index + 1u;
    RxInstance now = rx_instance_of_quads(after), was = now;
    if (known) was = rx_instance_of_quads(before);
    stir(was);
    stir(now);
    if (uintBitsToFloat(after[6].w) > 0.0 && (!known || way(was, now) > LEAP)) atomicMax(leaps, move);
}
