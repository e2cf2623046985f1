// Brings the numbers of particles into the order of cells. Within a cell they come as threads do.
#version 460
#include "water.glsl"

layout(local_size_x = 64) in;
layout(std430) readonly buffer Particles { Particle particles[]; };
layout(std430) readonly buffer Starts { uint starts[]; };
layout(std430) buffer Filled { uint filled[]; };
layout(std430) writeonly buffer Order { uint order[]; };

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= particles.length()) return;
    uint cell = particles[i].cell;
    order[starts[cell] + atomicAdd(filled[cell], 1u)] = i;
}
