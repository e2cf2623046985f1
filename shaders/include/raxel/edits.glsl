// Lets shaders edit the world. Bind `edits` to a buffer with `source = "world.edits"`. The buffer is empty when a frame begins. raxel
// applies all edits of a frame two frames later, as one step of undo. Invocations may write in any order, because raxel sorts the edits:
// restore, subtract, add, paint. Within each kind it sorts boxes, balls and voxels by their numbers.
#ifndef RAXEL_EDITS_GLSL
#define RAXEL_EDITS_GLSL

layout(std430) buffer RxEdits {
    uint count;  // of written records; raxel drops those without room, with a warning
    uint unused0;
    uint unused1;
    uint unused2;
    uint records[];  // eight words for each
} edits;

// The effect of an edit on the voxels that it covers.
const uint RX_EDIT_SUBTRACT = 0u;  // they become air; the material does not matter
const uint RX_EDIT_ADD = 1u;       // they become solid, of the material
const uint RX_EDIT_PAINT = 2u;     // the solid ones get the material

// The records of the functions below. The kind gives `a` and `b` their meaning.
void rx_edit_record(uint kind, uint mode, uint material, ivec3 a, ivec3 b) {
    uint index = atomicAdd(edits.count, 1u);
    if (index >= uint(edits.records.length()) / 8u) return;
    uint at = 8u * index;
    edits.records[at] = kind | mode << 8;
    edits.records[at + 1u] = mode == RX_EDIT_SUBTRACT ? 0u : material;
    for (uint axis = 0u; axis < 3u; ++axis) {
        edits.records[at + 2u + axis] = uint(a[axis]);
        edits.records[at + 5u + axis] = uint(b[axis]);
    }
}

// One voxel; material 0 empties it.
void rx_edit_set(ivec3 cell, uint material) {
    rx_edit_record(3u, material == 0u ? RX_EDIT_SUBTRACT : RX_EDIT_ADD, material, cell, ivec3(0));
}

// The voxels from `first` to `last`, both included.
void rx_edit_box(ivec3 first, ivec3 last, uint mode, uint material) {
    rx_edit_record(1u, mode, material, first, last);
}

// The voxels whose centres are within `radius` voxels of the centre of a voxel.
void rx_edit_sphere(ivec3 center, float radius, uint mode, uint material) {
    rx_edit_record(2u, mode, material, center, ivec3(int(round(256.0 * radius)), 0, 0));
}

// The voxels from `first` to `last`, both included, become as the world's file builds them.
void rx_edit_restore(ivec3 first, ivec3 last) {
    rx_edit_record(0u, RX_EDIT_SUBTRACT, 0u, first, last);
}

#endif
