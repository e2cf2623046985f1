// A world or a model bound as `NAME`, beside the one that is bound as `world`. `#include <raxel/world/NAME.glsl>` is this file with
// the shader's own name for the binding in the place of NAME, and that binding may have another layout than `world`:
//
//     bool NAME_trace(RxRay ray, out RxHit hit);
//     bool NAME_trace_from(RxRay ray, float t_free, out RxHit hit);
//     uint NAME_material(ivec3 cell);
//     RxMaterial NAME_material_properties(uint material);
//     bool NAME_set(ivec3 cell, uint material);   where RX_WRITE_NAME is defined, see <raxel/world.glsl>
//
// The image of the layout `texture3d` is bound as `NAME_voxels`, and to be written as `NAME_texels`. A graph compiles its shader with RX_LAYOUT_<LAYOUT>_NAME.
//
// Everything that a layout declares is called after the binding while it is read; rays, hits and the walk are shared.
#ifndef RAXEL_WORLD_OF_NAME_GLSL
#define RAXEL_WORLD_OF_NAME_GLSL

#include "../ray.glsl"
#include "../internal/walk.glsl"

#define world NAME
#define RxWorld NAME_World
#define world_voxels NAME_voxels
#define world_texels NAME_texels
#define rx_trace NAME_trace
#define rx_trace_from NAME_trace_from
#define rx_material NAME_material
#define rx_material_properties NAME_material_properties
#define rx_set NAME_set
#define RX_BRICK_WORDS NAME_BRICK_WORDS
#define RX_BVH_BLOCK_WORDS NAME_BVH_BLOCK_WORDS
#define RX_BVH_DEPTH NAME_BVH_DEPTH
#define RX_BVH_LEAF NAME_BVH_LEAF
#define RX_BVH_NODE_WORDS NAME_BVH_NODE_WORDS
#define RX_BVH_NONE NAME_BVH_NONE
#define RX_BVH_ROOM NAME_BVH_ROOM
#define RX_CHUNK_LEVEL NAME_CHUNK_LEVEL
#define RX_CHUNK_MASK_WORDS NAME_CHUNK_MASK_WORDS
#define RX_FILLED NAME_FILLED
#define RX_NO_CHUNK NAME_NO_CHUNK
#define RX_NO_ENTRY NAME_NO_ENTRY
#define RX_SECTOR_LEVEL NAME_SECTOR_LEVEL
#define RX_SOLID NAME_SOLID
#define RX_TOP_BIT NAME_TOP_BIT
#define RX_LINKED NAME_LINKED
#define RX_UNIFORM NAME_UNIFORM
#define RxBvhNode NAME_BvhNode
#define rx_block_material NAME_block_material
#define rx_block_solid NAME_block_solid
#define rx_block_voxel NAME_block_voxel
#define rx_brick_material NAME_brick_material
#define rx_bvh_cross NAME_bvh_cross
#define rx_bvh_enter NAME_bvh_enter
#define rx_bvh_enter_exactly NAME_bvh_enter_exactly
#define rx_bvh_meets NAME_bvh_meets
#define rx_bvh_node NAME_bvh_node
#define rx_child NAME_child
#define rx_child_rank NAME_child_rank
#define rx_chunk_at NAME_chunk_at
#define rx_chunk_cell NAME_chunk_cell
#define rx_chunk_index NAME_chunk_index
#define rx_chunk_key NAME_chunk_key
#define rx_chunk_node NAME_chunk_node
#define rx_chunk_voxel NAME_chunk_voxel
#define rx_cube_node NAME_cube_node
#define rx_find_chunk NAME_find_chunk
#define rx_find_instance NAME_find_instance
#define rx_find_sector NAME_find_sector
#define rx_free NAME_free
#define rx_free_block NAME_free_block
#define rx_free_octet NAME_free_octet
#define rx_grid_free NAME_grid_free
#define rx_grid_look NAME_grid_look
#define rx_half NAME_half
#define rx_has_child NAME_has_child
#define rx_store_voxel NAME_store_voxel
#define rx_in_world NAME_in_world
#define rx_instance NAME_instance
#define rx_keys_equal NAME_keys_equal
#define rx_last_cell NAME_last_cell
#define rx_last_chunk NAME_last_chunk
#define rx_last_cube NAME_last_cube
#define rx_last_height NAME_last_height
#define rx_last_leaf NAME_last_leaf
#define rx_last_node NAME_last_node
#define rx_last_sector NAME_last_sector
#define rx_last_voxels NAME_last_voxels
#define rx_leaf NAME_leaf
#define rx_leaf_mask NAME_leaf_mask
#define rx_filled_material NAME_filled_material
#define rx_leaf_material NAME_leaf_material
#define rx_linked_material NAME_linked_material
#define rx_look NAME_look
#define rx_looked_mask NAME_looked_mask
#define rx_node_mask NAME_node_mask
#define rx_mip_free NAME_mip_free
#define rx_occupied NAME_occupied
#define rx_palette_material NAME_palette_material
#define rx_search_chunk NAME_search_chunk
#define rx_table_find NAME_table_find
#define rx_table_free NAME_table_free
#define rx_table_slot NAME_table_slot
#define rx_trace_on NAME_trace_on
#define rx_voxel_material NAME_voxel_material
#define rx_voxel_number NAME_voxel_number
#define rx_word NAME_word

#define RX_NAMED_WORLD
#ifdef RX_WRITE_NAME
#define RX_WRITE
#define RX_WORLD_ACCESS coherent
#else
#define RX_WORLD_ACCESS readonly
#endif

#if defined(RX_LAYOUT_TREE64_NAME)
#include "../internal/layouts/tree64.glsl"
#elif defined(RX_LAYOUT_CHUNKS_NAME)
#include "../rivals/internal/layouts/chunks.glsl"
#elif defined(RX_LAYOUT_BVH_NAME)
#include "../rivals/internal/layouts/bvh.glsl"
#elif defined(RX_LAYOUT_CHUNK_TABLE_NAME)
#include "../rivals/internal/layouts/chunk_table.glsl"
#elif defined(RX_LAYOUT_BRICKMAP_NAME)
#include "../rivals/internal/layouts/brickmap.glsl"
#elif defined(RX_LAYOUT_OCTREE_NAME)
#include "../internal/layouts/octree.glsl"
#elif defined(RX_LAYOUT_SVO_NAME)
#include "../rivals/internal/layouts/svo.glsl"
#elif defined(RX_LAYOUT_SVDAG_NAME)
#include "../rivals/internal/layouts/svdag.glsl"
#elif defined(RX_LAYOUT_FLAT64_NAME)
#include "../internal/layouts/flat64.glsl"
#elif defined(RX_LAYOUT_TEXTURE3D_NAME)
#include "../rivals/internal/layouts/texture3d.glsl"
#else
#error "<raxel/world/NAME.glsl> needs a world or a model: bind `NAME` to a buffer with a source such as \"world.tree64\""
#endif

#undef RX_NAMED_WORLD
#undef RX_WRITE
#undef RX_WORLD_ACCESS
#undef world
#undef RxWorld
#undef world_voxels
#undef world_texels
#undef rx_trace
#undef rx_trace_from
#undef rx_material
#undef rx_material_properties
#undef rx_set
#undef RX_BRICK_WORDS
#undef RX_BVH_BLOCK_WORDS
#undef RX_BVH_DEPTH
#undef RX_BVH_LEAF
#undef RX_BVH_NODE_WORDS
#undef RX_BVH_NONE
#undef RX_BVH_ROOM
#undef RX_CHUNK_LEVEL
#undef RX_CHUNK_MASK_WORDS
#undef RX_FILLED
#undef RX_NO_CHUNK
#undef RX_NO_ENTRY
#undef RX_SECTOR_LEVEL
#undef RX_SOLID
#undef RX_TOP_BIT
#undef RX_LINKED
#undef RX_UNIFORM
#undef RxBvhNode
#undef rx_block_material
#undef rx_block_solid
#undef rx_block_voxel
#undef rx_brick_material
#undef rx_bvh_cross
#undef rx_bvh_enter
#undef rx_bvh_enter_exactly
#undef rx_bvh_meets
#undef rx_bvh_node
#undef rx_child
#undef rx_child_rank
#undef rx_chunk_at
#undef rx_chunk_cell
#undef rx_chunk_index
#undef rx_chunk_key
#undef rx_chunk_node
#undef rx_chunk_voxel
#undef rx_cube_node
#undef rx_find_chunk
#undef rx_find_instance
#undef rx_find_sector
#undef rx_free
#undef rx_free_block
#undef rx_free_octet
#undef rx_grid_free
#undef rx_grid_look
#undef rx_half
#undef rx_has_child
#undef rx_store_voxel
#undef rx_in_world
#undef rx_instance
#undef rx_keys_equal
#undef rx_last_cell
#undef rx_last_chunk
#undef rx_last_cube
#undef rx_last_height
#undef rx_last_leaf
#undef rx_last_node
#undef rx_last_sector
#undef rx_last_voxels
#undef rx_leaf
#undef rx_leaf_mask
#undef rx_filled_material
#undef rx_leaf_material
#undef rx_linked_material
#undef rx_look
#undef rx_looked_mask
#undef rx_node_mask
#undef rx_mip_free
#undef rx_occupied
#undef rx_palette_material
#undef rx_search_chunk
#undef rx_table_find
#undef rx_table_free
#undef rx_table_slot
#undef rx_trace_on
#undef rx_voxel_material
#undef rx_voxel_number
#undef rx_word

#endif
