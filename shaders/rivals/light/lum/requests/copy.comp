// Copies the blocks that have a slot out of the world. Nothing writes into the world itself.
#version 460
#include <raxel/world.glsl>
#include <raxel/thread.glsl>
#include "light/scene.glsl"
#define SCALE 1.0
#include "../field.glsl"
#include "block.glsl"
#include "work.glsl"

layout(local_size_x = 64) in;
layout(std430) readonly buffer Copies { uint copies[]; };
layout(std430) writeonly buffer Blocks { Block blocks[]; };

void main() {
    uint i = rx_thread();
    if (i >= work.copy_threads) return;
    uint place = copies[i / BLOCK_VOXELS];
    ivec3 block = ivec3(place & 1023u, place >> 10 & 1023u, place >> 20), within = ivec3(i & 15u, i >> 4 & 15u, i >> 8 & 15u);
    blocks[i / BLOCK_VOXELS].voxels[i % BLOCK_VOXELS] = rx_material(grid.world_min + 16 * block + within);
}
