// Sorts the particles by cells, and within a cell by their numbers. So sums over neighbours are the same
// bytes in every run.
#version 460
#include "water.glsl"

layout(local_size_x = 64) in;
layout(std430) readonly buffer Particles { Particle particles[]; };
layout(std430) readonly buffer Starts { uint starts[]; };
layout(std430) readonly buffer Order { uint order[]; };
layout(std430) writeonly buffer Sorted { Particle sorted[]; };

void main() {
    uint slot = gl_GlobalInvocationID.x;
    if (slot >= particles.length()) return;
    uint i = order[slot], cell = particles[i].cell, rank = starts[cell];
    for (uint k = starts[cell]; k < starts[cell + 1u]; ++k) rank += order[k] < i ? 1u : 0u;
    sorted[rank] = particles[i];
}
