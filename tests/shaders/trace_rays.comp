// Traces a list of rays through the bound world, for tests/tracer.rs.
#version 460
#include <raxel/world.glsl>

layout(local_size_x = 64) in;

// cell and t_max; fraction; direction. Words, so that no bit of a NaN or denormal is lost on the way.
struct RayWords {
    ivec3 cell;
    uint t_max;
    uvec4 frac;
    uvec4 dir;
};

struct HitWords {
    ivec3 voxel;
    uint found;
    uint face;
    uint material;
    uint looked_up;  // rx_material of the voxel
    uint t;
    uvec2 uv;
    uint steps;
    uint unused;
};

layout(std430) readonly buffer Rays { RayWords rays[]; };
layout(std430) writeonly buffer Hits { HitWords hits[]; };

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= rays.length()) return;
    RxRay ray = rx_ray(rays[i].cell, uintBitsToFloat(rays[i].frac.xyz), uintBitsToFloat(rays[i].dir.xyz));
    ray.t_max = uintBitsToFloat(rays[i].t_max);
    RxHit hit;
    bool found = rx_trace(ray, hit);
    hits[i] = HitWords(hit.voxel, found ? 1u : 0u, hit.face, hit.material, rx_material(hit.voxel), floatBitsToUint(hit.t),
                       floatBitsToUint(hit.uv), hit.steps, 0u);
}
