// The number of cells to search for grass: all of the world once after each change.
#version 460

layout(local_size_x = 1) in;
layout(std430) buffer Sown { uint todo; uint serial; } sown;
layout(push_constant) uniform Push { ivec3 world_min; ivec3 world_max; uint serial; } push;

void main() {
    uvec3 size = uvec3(push.world_max - push.world_min) + uvec3(0u, 1u, 0u);
    sown.todo = sown.serial == push.serial + 1u ? 0u : size.x * size.y * size.z;
    sown.serial = push.serial + 1u;
}
