// The hit of each path.
#version 460
#include <raxel/world.glsl>
#include <raxel/thread.glsl>
#include "wave.glsl"

layout(local_size_x = 64) in;
layout(std430) readonly buffer Queue { uint count; uint bins[WAVE_BINS]; } queue;
layout(std430) readonly buffer Paths { Path paths[]; };
layout(std430) readonly buffer Order { uint order[]; };
layout(std430) writeonly buffer Hits { PathHit hits[]; };
layout(push_constant) uniform Push { bool sorted; } push;

void main() {
    uint i = rx_thread();
    if (i >= queue.count) return;
    uint id = push.sorted ? order[i] : i;
    RxHit hit;
    bool found = rx_trace(rx_ray(paths[id].cell, paths[id].frac, paths[id].dir), hit);
    hits[id] = PathHit(found ? ivec4(hit.voxel, int(hit.material | hit.face << 16)) : ivec4(0, 0, 0, -1), vec4(hit.uv, hit.t, 0.0));
}
