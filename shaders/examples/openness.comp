// Measures the visible sky at the centre of each block of 16×16×16 voxels: the share of rays that hit nothing.
#version 460
#include <raxel/world.glsl>

layout(local_size_x = 4, local_size_y = 4, local_size_z = 4) in;
layout(rgba16f) uniform writeonly image3D outOpen;

layout(push_constant) uniform Push {
    ivec3 world_min;
    int rays;
} push;

const int BLOCK = 16;  // voxels along an axis: 1 / scale of the target's size

void main() {
    ivec3 texel = ivec3(gl_GlobalInvocationID);
    if (any(greaterThanEqual(texel, imageSize(outOpen)))) return;
    ivec3 cell = push.world_min + texel * BLOCK + BLOCK / 2;
    // Seen from the first free voxel above, where the centre is in the ground.
    for (int step = 0; step < BLOCK && rx_material(cell) != 0u; ++step) ++cell.y;
    float seen = 0.0;
    for (int i = 0; i < push.rays; ++i) {
        // Fibonacci's spiral on the upper half of the sphere, by equal areas.
        float y = (float(i) + 0.5) / float(push.rays);
        float turn = float(i) * 2.399963;
        vec3 dir = vec3(sqrt(1.0 - y * y) * vec2(cos(turn), sin(turn)), y).xzy;
        RxHit hit;
        if (!rx_trace(rx_ray(cell, vec3(0.5), dir), hit)) seen += 1.0;
    }
    imageStore(outOpen, texel, vec4(seen / float(push.rays)));
}
