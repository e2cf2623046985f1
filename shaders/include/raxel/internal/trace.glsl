// rx_trace for every layout that can look at a cell. Such a layout declares its block `world`, which has `origin` and `log2_size`, and
//
//     uint rx_look(ivec3 cell, out uint log2_free);
//
// the material of the voxel at `cell`, or 0. If it is 0, the cube of 2^log2_free voxels a side around the cell,
// aligned from world.origin, is empty. `cell` lies in the world's cube. The larger that cube, the fewer the
// steps; exactness does not depend on it.
#include "walk.glsl"
#if defined(RX_MARCH_RAYMASK) && !defined(RX_NAMED_WORLD)
#define RX_ASK_RAYMASK
#include "../rivals/march/raymask.glsl"
#endif

bool rx_in_world(ivec3 cell) {
    uvec3 c = uvec3(cell) - uvec3(world.origin);
    return ((c.x | c.y | c.z) >> world.log2_size) == 0u;
}

uint rx_material(ivec3 cell) {
    uint log2_free;
    return rx_in_world(cell) ? rx_look(cell, log2_free) : 0u;
}

// Goes on with a walk from the cell that it is in.
bool rx_trace_on(RxWalk walk, RxRay ray, out RxHit hit) {
    hit = RxHit(ivec3(0), 0u, 0u, 0.0, vec2(0.0), 0u);
    uvec3 flip = rx_walk_flip(walk, (1u << world.log2_size) - 1u);
    uvec3 limit = rx_walk_limit(walk, world.log2_size, world.bounds_min - world.origin, world.bounds_last - world.origin);
#ifdef RX_ASK_RAYMASK
    uvec3 asked = rx_raymask_block(walk);
#endif

    uint log2_free = 0u, material = 0u;
    bool unsure = false;
    // Every round leaves a block for good, and there are fewer than 3 * size blocks on a line.
    uint rounds = world.log2_size < 30u ? 4u << world.log2_size : 0xffffffffu;
    do {
        for (unsure = false; !unsure && hit.steps < rounds; ++hit.steps) {
            if (any(greaterThan(walk.q, limit)) || walk.t > walk.t_end) break;
            material = rx_look(world.origin + ivec3(walk.q ^ flip), log2_free);
            if (material != 0u) break;
#ifdef RX_ASK_RAYMASK
            if (log2_free < 2u && rx_raymask_misses(walk, asked)) log2_free = 2u;
#endif
            unsure = !rx_walk_step(walk, log2_free);
        }
        if (unsure) rx_walk_settle(walk, ray, world.origin, world.log2_size, log2_free);
    } while (unsure);

    if (material == 0u) return false;
    uint steps = hit.steps + 1u;
    bool within = rx_walk_hit(walk, ray, world.origin, world.log2_size, hit);
    hit.material = material;
    hit.steps = steps;
    return within;
}

// The first solid voxel along a ray, not looked for before `t_free` (in lengths of the direction): until then it passes air only.
bool rx_trace_from(RxRay ray, float t_free, out RxHit hit) {
    RxWalk walk;
    if (rx_walk_begin(ray, world.origin, world.log2_size, t_free, walk)) return rx_trace_on(walk, ray, hit);
    hit = RxHit(ivec3(0), 0u, 0u, 0.0, vec2(0.0), 0u);
    return false;
}

bool rx_trace(RxRay ray, out RxHit hit) {
    return rx_trace_from(ray, 0.0, hit);
}

#undef RX_ASK_RAYMASK
