// Gives a slot to each block that an instance touches, and notes which instance touches which block. A workgroup takes one instance after the other.
#version 460
#include "light/scene.glsl"
#define SCALE 1.0
#include "../field.glsl"
#include "box.glsl"
#include "block.glsl"
#include "work.glsl"

layout(local_size_x = 64) in;
layout(r32ui) uniform uimage3D slots;
layout(std430) writeonly buffer Copies { uint copies[]; };   // the block of each slot, its x, y and z in 10 bits each
layout(std430) writeonly buffer Draws { uvec2 draws[]; };    // block, instance

void touch(ivec3 block, uint instance) {
    uint place = uint(block.x | block.y << 10 | block.z << 20);
    uint at = atomicAdd(work.draw_threads, 64u) / 64u;
    if (at < draws.length()) draws[at] = uvec2(place, instance);
    else {
        atomicAdd(work.draw_threads, -64u);
        atomicAdd(work.no_draw, 1u);
    }
    // The first instance in a block takes the slot. Until it has one, the block is marked, so that no other does.
    if (imageAtomicCompSwap(slots, block, 0u, 0xffffffffu) != 0u) return;
    uint slot = atomicAdd(work.copy_threads, BLOCK_VOXELS) / BLOCK_VOXELS;
    if (slot < copies.length()) {
        copies[slot] = place;
        imageStore(slots, block, uvec4(slot + 1u));
    } else {
        atomicAdd(work.copy_threads, -BLOCK_VOXELS);
        atomicAdd(work.no_slot, 1u);
        imageStore(slots, block, uvec4(0u));
    }
}

void main() {
    for (uint index = gl_WorkGroupID.x; index < instances.count; index += gl_NumWorkGroups.x) {
        ivec3 low, high;
        box_of(rx_instance_of(index), low, high);
        // Parts outside of the world are left out.
        low = max(low, ivec3(0)) >> 4;
        high = min((high + 15) >> 4, imageSize(slots));
        if (any(lessThanEqual(high, low))) continue;
        uvec3 extent = uvec3(high - low);
        for (uint i = gl_LocalInvocationIndex; i < extent.x * extent.y * extent.z; i += gl_WorkGroupSize.x) {
            touch(low + ivec3(i % extent.x, i / extent.x % extent.y, i / (extent.x * extent.y)), index);
        }
    }
}
