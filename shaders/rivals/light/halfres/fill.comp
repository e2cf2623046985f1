// The second of two passes: the three pixels of four that tiles.comp has left, each from where their rays have met nothing together.
#version 460
#include <raxel/world.glsl>
#include <raxel/rivals/march/bundle.glsl>
#include "light/scene.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(r32f) uniform readonly image2D freeOfTile;
layout(rgba32i) uniform writeonly iimage2D outHit;
layout(rgba32f) uniform writeonly image2D outPlace;
#include "store.glsl"

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), size = imageSize(outHit);
    if (any(greaterThanEqual(pixel, size)) || ((pixel.x | pixel.y) & 1) == 0) return;
    trace_behind(pixel, ray_of(pixel, size), imageLoad(freeOfTile, pixel >> 1).x);
}
