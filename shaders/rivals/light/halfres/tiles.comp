// The first of two passes. A thread for each 2 x 2 pixels finds how far their four rays are free together, and the hit of the top left ray.
#version 460
#include <raxel/world.glsl>
#include <raxel/rivals/march/bundle.glsl>
#include "light/scene.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(r32f) uniform writeonly image2D outFree;       // how far the four rays get along their steepest axis, voxels
layout(rgba32i) uniform writeonly iimage2D outHit;    // as in see.comp
layout(rgba32f) uniform writeonly image2D outPlace;
#include "store.glsl"

void main() {
    ivec2 tile = ivec2(gl_GlobalInvocationID.xy), size = imageSize(outHit), pixel = 2 * tile;
    if (any(greaterThanEqual(pixel, size))) return;
    RxRay rays[RX_BUNDLE_RAYS];
    for (int i = 0; i < 4; ++i) rays[i] = ray_of(pixel + ivec2(i & 1, i >> 1), size);
    uint looks;
    float free = rx_bundle_free(rays, looks);
    imageStore(outFree, tile, vec4(free));
    trace_behind(pixel, rays[0], free);
}
