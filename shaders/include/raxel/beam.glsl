// Beams: how far ahead of the camera a whole tile of pixels is free. One thread marches the tile's middle ray through the halo of
// the world, which holds every 4^3 block that is occupied or touches one that is. While the middle is outside the halo, and the
// rays of the tile are within 4 voxels of it, none of them meets a solid voxel; so each may start where the beam ends, and hits
// what it hits anyway. Needs the layout `tree64`.
//
// Beams are from "Efficient Sparse Voxel Octrees" (Laine and Karras, 2010), whose rays start at the least of four corner rays;
// that passes over what is thin and lies between them. This one is conservative.
#ifndef RAXEL_BEAM_GLSL
#define RAXEL_BEAM_GLSL

#include "camera.glsl"

const float RX_BEAM_ROOM = 0.5;  // voxels of the 4 that are kept for rounding: of the march, and of the rays' directions

// The cube of the halo tree that holds cell c of the world's cube is empty: its log2 size; or 0, if c is in the halo.
uint rx_halo_free(uvec3 c) {
    uvec4 node = world.quads[world.halo];
    for (uint height = world.log2_size >> 1;; --height) {
        uint child = rx_child(c, height);
        if (!rx_has_child(node.xy, child)) return 2u * height - 2u + (rx_free_octet(node.xy, child) ? 1u : 0u);
        if (height == 2u) return 0u;
        uint next = node.z + rx_child_rank(node.xy, child);
        node = height == 3u ? uvec4(rx_leaf(next), 0u, 0u) : world.quads[next];
    }
}

// Depth (along the camera's axis, in voxels) up to which the rays through the middles of the pixels `first` to `last` meet no solid
// voxel; RX_FAR if they meet none at all.
float rx_beam(ivec3 cell, vec3 frac, mat4 view_to_world, vec2 tan_half_fov, ivec2 first, ivec2 last, ivec2 size) {
    // Positions are relative to the world's cube.
    ivec3 from = cell - world.origin;
    if (any(greaterThan(abs(from), ivec3(1 << 18))) || world.log2_size > 18u) return 0.0;
    vec3 origin = vec3(from) + frac;
    vec2 pixel = 2.0 * tan_half_fov / vec2(size);
    vec2 middle = (vec2(first + last + 1) * 0.5 - vec2(size) * 0.5) * pixel;
    vec3 dir = view_to_world[0].xyz * middle.x - view_to_world[1].xyz * middle.y - view_to_world[2].xyz;
    // Half the extent of the tile's rays at depth 1, along each axis.
    vec2 reach = vec2(last - first) * 0.5 * pixel;
    vec3 spread = abs(view_to_world[0].xyz) * reach.x + abs(view_to_world[1].xyz) * reach.y + 1.0e-6;
    float end = (4.0 - RX_BEAM_ROOM) / max(spread.x, max(spread.y, spread.z));

    vec3 inv = mix(1.0 / dir, vec3(RX_FAR), lessThan(abs(dir), vec3(1.0e-12)));
    // The box that holds all solids, and the blocks that touch them.
    vec3 low = vec3(world.bounds_min - world.origin) - 8.0, high = vec3(world.bounds_last - world.origin) + 9.0;
    vec3 near = (mix(high, low, greaterThan(dir, vec3(0.0))) - origin) * inv, far = (mix(low, high, greaterThan(dir, vec3(0.0))) - origin) * inv;
    // All rays of the tile go the same way along the axes that this one counts as leaving the box by.
    bvec3 certain = greaterThan(abs(dir), spread);
    vec3 leave = mix(vec3(RX_FAR), far, certain);
    float out_of_box = min(leave.x, min(leave.y, leave.z));
    float depth = max(0.0, max(near.x, max(near.y, near.z)));
    if (depth > 0.0) depth += 0.01;
    uint outside = ~((1u << world.log2_size) - 1u);

    for (int i = 0; i < 512; ++i) {
        if (depth >= out_of_box) return out_of_box <= end ? RX_FAR : end;
        if (depth >= end) return end;
        uvec3 c = uvec3(ivec3(floor(origin + depth * dir)));
        if (((c.x | c.y | c.z) & outside) != 0u) return depth;
        uint log2_free = rx_halo_free(c);
        if (log2_free == 0u) return depth;
        uint mask = (1u << log2_free) - 1u;
        vec3 exit = vec3(ivec3(mix(c & ~mask, (c | mask) + 1u, greaterThan(dir, vec3(0.0)))));
        vec3 t = mix((exit - origin) * inv, vec3(RX_FAR), lessThan(abs(dir), vec3(1.0e-12)));
        depth = max(depth, min(t.x, min(t.y, t.z))) + 0.01;
    }
    return depth;
}

// The same for one of these rays, in lengths of its direction.
float rx_beam_start(float depth, RxRay ray, mat4 view_to_world) {
    return depth >= RX_FAR ? RX_FAR : depth / max(-dot(ray.dir, view_to_world[2].xyz), 1.0e-6) * 0.99999 - 0.01;
}

#endif
