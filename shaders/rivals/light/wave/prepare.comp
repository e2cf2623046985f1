// Between two steps: where each bin begins, and the queues that are filled next are empty.
#version 460
#include "wave.glsl"

layout(local_size_x = 512) in;
layout(std430) readonly buffer Queue { uint count; uint bins[WAVE_BINS]; } queue;
layout(std430) writeonly buffer Next { uint count; uint bins[WAVE_BINS]; } next;
layout(std430) writeonly buffer Starts { uint starts[]; };
layout(std430) writeonly buffer Asking { uint asking; };
shared uint sums[512];

void main() {
    uint i = gl_LocalInvocationIndex, mine = queue.bins[i];
    sums[i] = mine;
    for (uint step = 1u; step < 512u; step <<= 1) {
        barrier();
        uint left = i >= step ? sums[i - step] : 0u;
        barrier();
        sums[i] += left;
    }
    starts[i] = sums[i] - mine;
    next.bins[i] = 0u;
    if (i == 0u) {
        next.count = 0u;
        asking = 0u;
    }
}
