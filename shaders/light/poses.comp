// Keeps where instances are, and where they were in the last frame; counts the frames in which one has moved, by how many. For moved.glsl.
#version 460
#include <raxel/instance_block.glsl>

layout(local_size_x = 64) in;
// For each instance the eight quads of the last frame, then those of this one.
layout(std430) buffer Poses { uint moves; uint unused0; uint unused1; uint unused2; uvec4 poses[]; };

const uint QUADS = 8u;

void main() {
    uint index = gl_GlobalInvocationID.x;
    if (index >= instances.count) return;
    uint at = 2u * QUADS * index;
    bool moved = false, known = false;
    for (uint i = 0u; i < QUADS; ++i) {
        uvec4 was = poses[at + QUADS + i], now = instances.quads[instances.first + QUADS * index + i];
        known = known || was != uvec4(0u);
        moved = moved || was != now;
        poses[at + i] = was;
        poses[at + QUADS + i] = now;
    }
    // One that has just come was nowhere else.
    if (!known) {
        for (uint i = 0u; i < QUADS; ++i) poses[at + i] = poses[at + QUADS + i];
    }
    if (moved) atomicAdd(moves, 1u);
}
