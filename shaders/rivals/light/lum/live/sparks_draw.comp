// Draws the sparks into the world, each as one glowing voxel where there is air. The radiance field sees them as it sees all that glows.
#version 460
#define RX_WRITE_world
#define LIVE
#include <raxel/world.glsl>
#include <raxel/world/still.glsl>
#include "../matter.glsl"

layout(local_size_x = 64) in;
struct Spark { vec3 at; float left; vec3 speed; float unused; };
layout(std430) readonly buffer Sparks { Spark sparks[]; };
layout(std430) writeonly buffer Cells { ivec4 cells[]; };

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= sparks.length()) return;
    ivec3 cell = ivec3(floor(sparks[i].at));
    bool drawn = sparks[i].left > 0.0 && still_material(cell) == 0u && rx_set(cell, SPARK);
    cells[i] = ivec4(cell, drawn ? 1 : 0);
}
