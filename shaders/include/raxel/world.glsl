// The bound world. A graph that binds `world = "…"` to a buffer with `source = "world.<layout>"` compiles its shader with
// RX_LAYOUT_<LAYOUT>; whichever it is, a shader uses
//
//     bool rx_trace(RxRay ray, out RxHit hit);             first solid voxel along a ray, exactly
//     bool rx_trace_from(RxRay ray, float t_free, out RxHit hit);  the same, for a ray that passes only air until t_free
//     uint rx_material(ivec3 cell);                        material of a voxel, 0 for air
//     RxMaterial rx_material_properties(uint material);
//
// A shader that defines RX_WRITE_world before this include, and binds a writable copy of a world (`copy = "world.<layout>"`), also has
//
//     bool rx_set(ivec3 cell, uint material);              makes a voxel of a material, or air; false if the copy has no room there
//
// in the layouts chunks, chunk_table, octree and texture3d. Many threads may set voxels at once. If several set the same voxel, one of them
// wins. Later passes see the new voxels; rx_trace and rx_material of the same dispatch do not. docs/layouts.md describes each layout.
//
// Other worlds and models are bound beside this one under their own names: see world/NAME.glsl.
#ifndef RAXEL_WORLD_GLSL
#define RAXEL_WORLD_GLSL

#include "ray.glsl"
#include "internal/walk.glsl"

#ifdef RX_WRITE_world
#define RX_WRITE
#define RX_WORLD_ACCESS coherent
#else
#define RX_WORLD_ACCESS readonly
#endif

#if defined(RX_LAYOUT_TREE64)
#include "internal/layouts/tree64.glsl"
#elif defined(RX_LAYOUT_CHUNKS)
#include "rivals/internal/layouts/chunks.glsl"
#elif defined(RX_LAYOUT_BVH)
#include "rivals/internal/layouts/bvh.glsl"
#elif defined(RX_LAYOUT_CHUNK_TABLE)
#include "rivals/internal/layouts/chunk_table.glsl"
#elif defined(RX_LAYOUT_BRICKMAP)
#include "rivals/internal/layouts/brickmap.glsl"
#elif defined(RX_LAYOUT_OCTREE)
#include "internal/layouts/octree.glsl"
#elif defined(RX_LAYOUT_SVO)
#include "rivals/internal/layouts/svo.glsl"
#elif defined(RX_LAYOUT_SVDAG)
#include "rivals/internal/layouts/svdag.glsl"
#elif defined(RX_LAYOUT_FLAT64)
#include "internal/layouts/flat64.glsl"
#elif defined(RX_LAYOUT_TEXTURE3D)
#include "rivals/internal/layouts/texture3d.glsl"
#else
#error "<raxel/world.glsl> needs a world: bind `world` to a buffer with a source such as \"world.tree64\""
#endif

#undef RX_WRITE
#undef RX_WORLD_ACCESS

// The hit of rx_trace without its steps, for a ray whose voxel and face are known, for example from packet.glsl.
RxHit rx_hit_of(RxRay ray, ivec3 voxel, uint face) {
    RxHit hit;
    rx_walk_known_hit(ray, world.origin, world.log2_size, voxel, face, hit);
    hit.material = rx_material(voxel);
    return hit;
}

#endif
