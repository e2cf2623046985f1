// The receivers of new light in a frame: texels of wide faces, and the others whole. WORK_ACCESS is empty where the shader writes it.
#ifndef WORK_ACCESS
#define WORK_ACCESS readonly
#endif

layout(std430) WORK_ACCESS buffer Work {
    uint count;      // items
    uint paths;      // in all
    uint per_item;   // paths for each
    uint wanted;     // items that all faces in sight are
    uint taken;      // blocks of texels that have been taken from faces in sight (warned of)
} work;
layout(std430) WORK_ACCESS buffer Items { uint items[]; };   // a slot, or with the highest bit set a texel

const uint NO_ITEM = 0xffffffffu, TEXEL_ITEM = 0x80000000u;
