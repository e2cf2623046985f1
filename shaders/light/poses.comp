// Keeps the poses of instances in this frame and the last one, for moved.glsl and face_cache/moves.glsl. Counts moved instances, so the count changes
// after each frame with a move. Notes the count when a lamp goes far in a frame.
#version 460
#include <raxel/instance_frame.glsl>

layout(local_size_x = 64) in;
// For each instance the eight quads of the last frame, then those of this one.
layout(std430) buffer Poses { uint moves; uint leaps; uint unused1; uint unused2; uvec4 poses[]; };

const uint QUADS = RX_INSTANCE_QUADS;
const float LEAP = 1.0;   // voxels in a frame

// About the distance that the farthest voxel of an instance has gone.
float way(RxInstance was, RxInstance now) {
    vec3 step = vec3(now.cell - was.cell) + (vec3(now.fraction) - vec3(was.fraction)) / 16777216.0;
    ivec3 turn = max(max(abs(now.row_x - was.row_x), abs(now.row_y - was.row_y)), abs(now.row_z - was.row_z));
    vec3 size = vec3(now.high - now.low);
    bool other = was.shape != now.shape;
    return length(step) + (other ? 1.0 : float(max(turn.x, max(turn.y, turn.z))) / 8388608.0) * max(size.x, max(size.y, size.z));
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
    if (uintBitsToFloat(after[6].w) > 0.0 && way(rx_instance_of_quads(before), rx_instance_of_quads(after)) > LEAP) atomicMax(leaps, move);
}
