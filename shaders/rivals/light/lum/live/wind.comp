// A tick of the wind: the bend of grass, in voxels at the tip, on a map that repeats after 64 voxels. It is the slope of noise
// that moves over the world (Lum's updateGrass).
#version 460
#include <raxel/random.glsl>

layout(local_size_x = 8, local_size_y = 8) in;
layout(rg16f) uniform writeonly image2D outWind;
layout(push_constant) uniform Push { uint tick; float delta; } push;

float value(ivec2 cell, int period) {
    cell = ivec2(mod(vec2(cell), float(period)));
    return float(rx_hash(ivec3(cell, period)) >> 8) * 5.9604644775390625e-8;
}

// Value noise that repeats after `period` cells.
float noise(vec2 at, int period) {
    ivec2 cell = ivec2(floor(at));
    vec2 part = at - vec2(cell);
    part = part * part * (3.0 - 2.0 * part);
    return mix(mix(value(cell, period), value(cell + ivec2(1, 0), period), part.x),
               mix(value(cell + ivec2(0, 1), period), value(cell + ivec2(1, 1), period), part.x), part.y);
}

void main() {
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy), size = imageSize(outWind);
    if (any(greaterThanEqual(texel, size))) return;
    vec2 at = (vec2(texel) + 0.5) / vec2(size);
    float time = float(push.tick) * push.delta, gust = 0.0, across = 0.0;
    // Gusts travel along +x; smaller ones faster.
    for (int i = 0; i < 3; ++i) {
        int period = 4 << i;
        gust += noise(float(period) * (at - vec2(0.05 * time * float(i + 1), 0.02 * time)), period) / float(i + 1);
        across += (noise(float(period) * (at + vec2(0.03 * time, 0.21)), period) - 0.5) / float(i + 1);
    }
    imageStore(outWind, texel, vec4(0.30 * gust, 0.35 * across, 0.0, 0.0));
}
