// Draws instances over the copied blocks. 64 threads take an instance in a block. Of several instances at a voxel, the last one of the world's file stays.
#version 460
#include <raxel/thread.glsl>
#include "light/scene.glsl"
#define SCALE 1.0
#include "../field.glsl"
#include "box.glsl"
#include "block.glsl"
#include "work.glsl"

layout(local_size_x = 64) in;
layout(r32ui) uniform readonly uimage3D slots;
layout(std430) readonly buffer Draws { uvec2 draws[]; };
layout(std430) buffer Blocks { Block blocks[]; };

void main() {
    uint thread = rx_thread();
    if (thread >= work.draw_threads) return;
    uvec2 todo = draws[thread / 64u];
    ivec3 block = ivec3(todo.x & 1023u, todo.x >> 10 & 1023u, todo.x >> 20);
    uint slot = imageLoad(slots, block).x;
    if (slot == 0u) return;
    RxInstance instance = rx_instance_of(todo.y);
    for (uint i = thread & 63u; i < BLOCK_VOXELS; i += 64u) {
        uint material = material_of(instance, 16 * block + ivec3(i & 15u, i >> 4 & 15u, i >> 8));
        if (material != 0u) atomicMax(blocks[slot - 1u].voxels[i], (todo.y + 1u) << 16 | material);
    }
}
