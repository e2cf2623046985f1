// Finds the height and the colour of the ground around a finite world: those of the land at the world's border, seen from above. A world with
// walls at its border, for example a cube, stands on a plane at its lowest level. A streamed world needs no ground, and an empty one has none.
#version 460
#include <raxel/world.glsl>
#include "land.glsl"

const uint SAMPLES = 4u, THREADS = 64u;
layout(local_size_x = THREADS) in;
layout(rgba32f) uniform writeonly image2D outLand;
layout(push_constant) uniform Push { ivec3 low; uint kind; ivec3 high; float drop; vec3 tint; uint voxels; } push;

const uint STREAMED = 0xffffffffu;   // `world.voxels` of a streamed world

shared vec4 colors[THREADS];   // the sum of albedos; of how many places
shared int levels[THREADS];    // the lowest surface

// The n-th of `all` places along the border, in the cells that lie within it.
ivec2 border_cell(uint n, uint all) {
    ivec2 size = push.high.xz - push.low.xz - 1;
    int side = int(n & 3u);
    float along = (float(n >> 2) + 0.5) / float(all >> 2);
    ivec2 cell = ivec2(along * vec2(size));
    if ((side & 1) == 0) cell.x = side == 0 ? 0 : size.x;
    else cell.y = side == 1 ? 0 : size.y;
    return push.low.xz + cell;
}

void main() {
    uint own = gl_LocalInvocationIndex;
    vec4 sum = vec4(0.0);
    int lowest = push.high.y;
    bool finite = push.voxels != 0u && push.voxels != STREAMED && push.kind != LAND_NONE;
    for (uint i = 0u; finite && i < SAMPLES; ++i) {
        ivec2 cell = border_cell(own * SAMPLES + i, THREADS * SAMPLES);
        RxHit hit;
        if (!rx_trace(rx_ray(ivec3(cell.x, push.high.y, cell.y), vec3(0.5), vec3(0.0, -1.0, 0.0)), hit)) continue;
        sum += vec4(rx_material_properties(hit.material).albedo, 1.0);
        lowest = min(lowest, hit.voxel.y + 1);
    }
    colors[own] = sum;
    levels[own] = lowest;
    barrier();
    if (own != 0u) return;
    for (uint i = 1u; i < THREADS; ++i) {
        sum += colors[i];
        lowest = min(lowest, levels[i]);
    }
    ivec3 size = push.high - push.low;
    bool ground = sum.w > 0.0 && 4 * (lowest - push.low.y) <= min(size.x, size.z);
    float level = float(ground ? lowest : push.low.y) - push.drop;
    vec3 albedo = push.kind == LAND_SEA ? LAND_SEA_ALBEDO : ground ? sum.rgb / sum.w : LAND_PLAIN_ALBEDO;
    imageStore(outLand, ivec2(0), vec4(clamp(albedo * push.tint, 0.0, 1.0), level));
    imageStore(outLand, ivec2(1, 0), vec4(float(finite ? push.kind : LAND_NONE), 0.0, 0.0, 0.0));
}
