// The list of a frame: which blocks are copied, and which instances are drawn into which blocks.
layout(std430) buffer Work {
    uint copy_threads;   // 4096 for each block
    uint draw_threads;   // 64 for each instance in a block
    uint no_slot;        // blocks that found no slot
    uint no_draw;        // instances in blocks that found no room in the list
} work;
