// Micro-voxels: cells of the world that hold 4³ smaller voxels each, traced exactly. A pass keeps them in an integer texture of two channels (`rg32ui`),
// a texel for each cell. Of its 64 bits, the first 32 are in the first channel.
//
//     uint rx_micro_bit(ivec3 voxel);      the bit of a micro-voxel in its cell: x + 4z + 16y, each from 0 to 3
//     RxRay rx_micro_ray(RxRay ray);       a ray of the world, on the lattice of micro-voxels
//     bool rx_trace_micro(usampler3D micro, ivec3 corner, RxRay ray, out RxHit hit);   the first micro-voxel along such a ray
//     RxRay rx_world_ray(RxRay ray);       a ray on the lattice of micro-voxels, in the world
//
// `corner` is the cell of the world that the first texel stands for. A cell of the world is 4 cells long on the lattice of micro-voxels. So the `voxel`
// and `t_max` of rays there, and the `voxel` and `t` of hits, are 4 times those of the world. rx_ray_from_face leaves a micro-voxel as it leaves a voxel.
// Cells of the world whose coordinates are beyond 2^29 have no place on this lattice.
#ifndef RAXEL_MICRO_GLSL
#define RAXEL_MICRO_GLSL

#include "ray.glsl"
#include "internal/mask.glsl"
#include "internal/walk.glsl"

// The bit of a micro-voxel; only the two lowest bits of each coordinate count.
uint rx_micro_bit(ivec3 voxel) {
    return rx_mask_bit(uvec3(voxel));
}

// Whether there is a micro-voxel at a place of the texture, in micro-voxels.
bool rx_micro_has(usampler3D micro, ivec3 place) {
    return rx_mask_has(texelFetch(micro, place >> 2, 0).xy, rx_micro_bit(place));
}

// The same ray, 4 cells for each of the world's. Both are the same to the last bit: fractions of a cell are multiples of 2^-24.
RxRay rx_micro_ray(RxRay ray) {
    vec3 fixed_frac = floor(clamp(ray.frac, 0.0, 1.0) * 16777216.0) * 2.384185791015625e-7;   // 2^-22
    // A ray that begins on the far face of its cell stays in the last micro-voxel of it.
    vec3 cell = min(floor(fixed_frac), vec3(3.0));
    return RxRay(4 * ray.cell + ivec3(cell), fixed_frac - cell, ray.dir, ray.t_max >= 1.0e37 ? RX_FAR : 4.0 * ray.t_max);
}

// The same ray in the world, its place rounded to what a float between 0 and 1 holds.
RxRay rx_world_ray(RxRay ray) {
    return RxRay(ray.cell >> 2, 0.25 * (vec3(ray.cell & 3) + ray.frac), ray.dir, ray.t_max >= 1.0e37 ? RX_FAR : 0.25 * ray.t_max);
}

// The first micro-voxel along a ray on their lattice. Its material is 1.
bool rx_trace_micro(usampler3D micro, ivec3 corner, RxRay ray, out RxHit hit) {
    hit = RxHit(ivec3(0), 0u, 0u, 0.0, vec2(0.0), 0u);
    ivec3 first = 4 * corner, size = 4 * textureSize(micro, 0);
    uint log2_size = uint(findMSB(max(size.x, max(size.y, size.z)) - 1)) + 1u;
    RxWalk walk;
    if (!rx_walk_begin(ray, first, log2_size, 0.0, walk)) return false;
    uvec3 flip = rx_walk_flip(walk, (1u << log2_size) - 1u);
    uvec3 limit = rx_walk_limit(walk, log2_size, ivec3(0), size - 1);
    uint log2_free = 0u, rounds = 4u << log2_size;
    bool solid = false, unsure = false;
    do {
        for (unsure = false; !unsure && hit.steps < rounds; ++hit.steps) {
            if (any(greaterThan(walk.q, limit)) || walk.t > walk.t_end) break;
            uvec3 place = walk.q ^ flip;
            // Before the limit, but outside of the texture on another axis, a texel is 0.
            uvec2 mask = any(greaterThanEqual(ivec3(place), size)) ? uvec2(0u) : texelFetch(micro, ivec3(place >> 2u), 0).xy;
            uint bit = rx_mask_bit(place);
            solid = rx_mask_has(mask, bit);
            if (solid) break;
            log2_free = rx_mask_free(mask, bit);
            unsure = !rx_walk_step(walk, log2_free);
        }
        if (unsure) rx_walk_settle(walk, ray, first, log2_size, log2_free);
    } while (unsure);
    if (!solid) return false;
    uint steps = hit.steps + 1u;
    bool within = rx_walk_hit(walk, ray, first, log2_size, hit);
    hit.material = 1u;
    hit.steps = steps;
    return within;
}

#endif
