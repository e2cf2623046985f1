#version 460
#include <raxel/world.glsl>
#include <raxel/thread.glsl>
#include "wave.glsl"
layout(local_size_x = 64) in;
layout(std430) readonly buffer Queue { uint count; uint bins[BINS]; } queue;
layout(std430) readonly buffer Paths { Path paths[]; };
layout(std430) readonly buffer Order { uint order[]; };
layout(std430) writeonly buffer Hits { Hit hits[]; };
void main() {
    uint i = rx_thread();
    if (i >= queue.count) return;
    uint id = order[i];
    RxHit hit;
    bool found = rx_trace(rx_ray(paths[id].cell, paths[id].frac, paths[id].dir), hit);
    hits[id] = Hit(found ? ivec4(hit.voxel, pack_hit(hit.material, hit.face)) : ivec4(0, 0, 0, -1), ivec4(floatBitsToInt(hit.uv), 0, 0));
}
