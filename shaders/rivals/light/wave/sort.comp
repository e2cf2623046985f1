// The order of paths by bins.
#version 460
#include <raxel/thread.glsl>
#include "wave.glsl"

layout(local_size_x = 64) in;
layout(std430) readonly buffer Queue { uint count; uint bins[WAVE_BINS]; } queue;
layout(std430) readonly buffer Paths { Path paths[]; };
layout(std430) buffer Starts { uint starts[]; };
layout(std430) writeonly buffer Order { uint order[]; };

void main() {
    uint i = rx_thread();
    if (i < queue.count) order[atomicAdd(starts[paths[i].bin], 1u)] = i;
}
