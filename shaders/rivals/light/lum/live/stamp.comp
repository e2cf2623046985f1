// Draws the requested models into the world, voxel by voxel, and notes where, so that the next frame can take them out. Picture and world show
// the same models, because rays of all passes meet them like everything else.
#version 460
#define RX_WRITE_world
#include <raxel/world.glsl>
#include <raxel/world/model.glsl>
#include "requests.glsl"
#include "model.glsl"

layout(local_size_x = 4, local_size_y = 4, local_size_z = 4) in;
layout(std430) readonly buffer Palette { uint palette[]; };
layout(std430) buffer PlacedModels { Placed placed[]; };
layout(push_constant) uniform Push { float time; } push;

void main() {
    ivec3 thread = ivec3(gl_GlobalInvocationID);
    int number = thread.z / EDGE;
    if (number >= request_count()) return;
    Placed here = placement(number, push.time);
    thread.z %= EDGE;
    if (thread == ivec3(0)) placed[number] = here;
    ivec3 cell = cell_of(here, thread);
    uint material = model_cell(here, cell);
    if (material != 0u) rx_set(cell, palette[min(material, uint(palette.length()) - 1u)]);
}
