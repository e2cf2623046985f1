// Traces the rays of Lum's passes through the world; with REQUESTS, also through the copies of its blocks with models drawn in. Needs field.glsl.
#ifdef REQUESTS
#include "requests/blocks.glsl"

// The first solid voxel along a ray. A copy has all voxels of its block, so where both are met at once, the copy counts.
bool lum_trace(RxRay ray, out RxHit hit) {
    bool found = rx_trace(ray, hit);
    RxHit copied;
    if (found) ray.t_max = min(ray.t_max, hit.t);
    if (!trace_blocks(ray, copied)) return found;
    copied.steps += hit.steps;
    hit = copied;
    return true;
}
#else
#define lum_trace rx_trace
#endif
