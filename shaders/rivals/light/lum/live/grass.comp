// Marks the air on grass as a cell of blades.
#version 460
#define RX_WRITE_world
#define LIVE
#include <raxel/world.glsl>
#include <raxel/world/still.glsl>
#include <raxel/thread.glsl>
#include "../matter.glsl"
#include "still.glsl"

layout(local_size_x = 64) in;
layout(std430) readonly buffer Sown { uint todo; uint serial; } sown;
layout(push_constant) uniform Push { ivec3 world_min; uint grass; ivec3 world_max; } push;

void main() {
    uint i = rx_thread();
    if (i >= sown.todo) return;
    uvec3 size = uvec3(push.world_max - push.world_min) + uvec3(0u, 1u, 0u);
    ivec3 cell = push.world_min + ivec3(i % size.x, i / size.x / size.z, i / size.x % size.z);
    if (still_cell(cell, push.grass) == GRASS_CELL) rx_set(cell, GRASS_CELL);
}
