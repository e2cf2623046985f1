// Takes the sparks of the last frame out of the world.
#version 460
#define RX_WRITE_world
#define LIVE
#include <raxel/world.glsl>
#include <raxel/world/still.glsl>
#include "../matter.glsl"
#include "still.glsl"

layout(local_size_x = 64) in;
layout(std430) readonly buffer Cells { ivec4 cells[]; };   // w is 1 where a spark was drawn
layout(push_constant) uniform Push { uint grass; } push;

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i < cells.length() && cells[i].w != 0) rx_set(cells[i].xyz, still_cell(cells[i].xyz, push.grass));
}
