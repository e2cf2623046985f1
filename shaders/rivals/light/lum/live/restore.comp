// Takes the models of the last frame out of the world, and restores every voxel that they covered. Lum copies blocks instead: it copies the
// blocks that a model touches before it draws the model, and restores them afterwards.
#version 460
#define RX_WRITE_world
#define LIVE
#include <raxel/world.glsl>
#include <raxel/world/still.glsl>
#include <raxel/world/model.glsl>
#include "../matter.glsl"
#include "still.glsl"
#include "requests.glsl"
#include "model.glsl"

layout(local_size_x = 4, local_size_y = 4, local_size_z = 4) in;
layout(std430) readonly buffer PlacedModels { Placed placed[]; };
layout(push_constant) uniform Push { uint grass; } push;

void main() {
    ivec3 thread = ivec3(gl_GlobalInvocationID);
    int number = thread.z / EDGE;
    if (number >= request_count() || placed[number].drawn == 0u) return;
    ivec3 cell = cell_of(placed[number], ivec3(thread.xy, thread.z % EDGE));
    if (model_cell(placed[number], cell) != 0u) rx_set(cell, still_cell(cell, push.grass));
}
