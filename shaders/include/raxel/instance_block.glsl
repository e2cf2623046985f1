// The block of a buffer with `source = "world.instances"`, for passes that ask how many there are and trace nothing: `instances.count`.
#ifndef RAXEL_INSTANCE_BLOCK_GLSL
#define RAXEL_INSTANCE_BLOCK_GLSL

layout(std430) readonly buffer RxInstances {
    uint count;     // how many there are
    uint first;     // the first one, in quads
    uint lamps;     // how many of them give off light
    uint lamps_at;  // the list of these, in quads
    uvec4 quads[];
} instances;

#endif
