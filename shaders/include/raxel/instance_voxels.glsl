// The voxels of instances, for passes that look at cells and trace nothing. Bind `instances` to a buffer with `source = "world.instances"`; a world
// is not needed:
//
//     RxInstance rx_instance_of(uint index);                         instance_frame.glsl says where it stands
//     uvec3 rx_instance_cell(RxInstance instance, uvec3 cell);       a cell of its cube, turned to one of its model's
//     uint rx_instance_look(RxInstance instance, uvec3 c, out uint log2_free);   the material there, by its index in the world
#ifndef RAXEL_INSTANCE_VOXELS_GLSL
#define RAXEL_INSTANCE_VOXELS_GLSL

#include "instance_frame.glsl"
#include "internal/mask.glsl"

// A cell of the cube of an instance, as a cell of its model's cube.
uvec3 rx_instance_cell(RxInstance instance, uvec3 cell) {
    uint last = (1u << (instance.shape & 31u)) - 1u;
    uvec3 turned = uvec3(0u);
    for (uint axis = 0u; axis < 3u; ++axis) {
        uint c = rx_pick(cell, rx_instance_axis(instance, axis));
        rx_put(turned, axis, rx_instance_turns_around(instance, axis) ? last - c : c);
    }
    return turned;
}

// A word of the tree of an instance's model.
uint rx_instance_word(RxInstance instance, uint at) {
    return instances.quads[instance.tree + (at >> 2)][at & 3u];
}

// The world's index of a voxel's material. tree64.glsl explains leaves, packed.glsl explains packed materials.
uint rx_instance_material(RxInstance instance, uint material, uint rank, uvec2 leaf, uint voxel) {
    uint own = material & 0xffffu;
    if ((material & 0xc0000000u) == 0u) {
        uint link = rx_instance_word(instance, material + rank);
        own = link & 0xffffu;
        if ((link & 0x40000000u) == 0u) {
            uint at = link & 0x1fffffffu, code = ((link >> 30) & 2u) | ((link >> 29) & 1u), kind = code == 3u ? 4u : code;
            uint bit = rx_mask_rank(leaf, voxel) << kind, bits = 1u << kind;
            uint palette_words = kind == 4u ? 0u : (1u << bits) >> 1;
            own = (rx_instance_word(instance, at + palette_words + (bit >> 5)) >> (bit & 31u)) & ((1u << bits) - 1u);
            if (kind != 4u) own = (rx_instance_word(instance, at + (own >> 1)) >> (16u * (own & 1u))) & 0xffffu;
        }
    }
    return rx_instance_word(instance, 8u * own + 7u);
}

// As rx_look of trace.glsl: the material of a cell of the model's cube, or 0 and an empty cube around it.
uint rx_instance_look(RxInstance instance, uvec3 c, out uint log2_free) {
    uvec4 node = instances.quads[instance.tree + instance.root];
    log2_free = 0u;
    for (uint height = (instance.shape & 31u) >> 1;; --height) {
        uint child = rx_mask_bit(c >> (2u * height - 2u));
        if (!rx_mask_has(node.xy, child)) {
            log2_free = 2u * height - 2u + rx_mask_free(node.xy, child);
            return 0u;
        }
        uint rank = rx_mask_rank(node.xy, child);
        if ((node.w & 0x80000000u) != 0u) return rx_instance_material(instance, node.w, rank, uvec2(0u), 0u);
        if (height == 2u) {
            uint at = node.z + rank;
            uvec4 pair = instances.quads[instance.tree + (at >> 1)];
            uvec2 leaf = (at & 1u) != 0u ? pair.zw : pair.xy;
            uint voxel = rx_mask_bit(c);
            if (rx_mask_has(leaf, voxel)) return rx_instance_material(instance, node.w, rank, leaf, voxel);
            log2_free = rx_mask_free(leaf, voxel);
            return 0u;
        }
        node = instances.quads[instance.tree + node.z + rank];
    }
}

#endif
