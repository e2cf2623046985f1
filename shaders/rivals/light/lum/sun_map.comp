// Depths as the sun sees them. Lum draws them as a shadow map; here rays find them, when the sun or the world changes.
#version 460
#include <raxel/world.glsl>
#include "light/scene.glsl"
#define SCALE 1.0
#include "field.glsl"
#include "trace.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(r16) uniform writeonly image2D outMap;

void main() {
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy), size = imageSize(outMap);
    if (any(greaterThanEqual(texel, size))) return;
    vec3 sun = frame_sun(), t, b;
    rx_basis(sun, t, b);
    float half_side = map_half();
    vec2 at = ((vec2(texel) + 0.5) / vec2(size) * 2.0 - 1.0) * half_side;
    vec3 from = map_middle() + half_side * sun + at.x * t + at.y * b;
    ivec3 cell = ivec3(floor(from));
    RxHit hit;
    bool found = lum_trace(rx_ray(grid.world_min + cell, from - vec3(cell), -sun), hit);
    imageStore(outMap, texel, vec4(found ? hit.t / (2.0 * half_side) : 1.0));
}
