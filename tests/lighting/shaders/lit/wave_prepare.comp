// Between two bounces: where each bin begins, and the other queue emptied.
#version 460
#include "wave.glsl"
layout(local_size_x = 512) in;
layout(std430) readonly buffer Queue { uint count; uint bins[BINS]; } queue;
layout(std430) writeonly buffer Next { uint count; uint bins[BINS]; } next;
layout(std430) writeonly buffer Starts { uint starts[]; };
shared uint sums[512];
void main() {
    uint i = gl_LocalInvocationIndex;
    uint mine = queue.bins[i];
    sums[i] = mine;
    for (uint s = 1u; s < 512u; s <<= 1) {
        barrier();
        uint left = i >= s ? sums[i - s] : 0u;
        barrier();
        sums[i] += left;
    }
    starts[i] = sums[i] - mine;
    next.bins[i] = 0u;
    if (i == 0u) next.count = 0u;
}
