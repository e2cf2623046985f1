// Every face of a voxel that gives off light and is bare. Depends on the world alone: the memo runs it once a world.
#version 460
#include <raxel/world.glsl>
layout(local_size_x = 4, local_size_y = 4, local_size_z = 4) in;
layout(std430) buffer Lamps { uint count; uint pad[3]; ivec4 at[]; } lamps;
layout(push_constant) uniform Push { ivec3 world_min; ivec3 world_max; } push;
void main() {
    ivec3 cell = push.world_min + ivec3(gl_GlobalInvocationID);
    if (any(greaterThanEqual(cell, push.world_max))) return;
    uint material = rx_material(cell);
    if (material == 0u || rx_material_properties(material).emission <= 0.0) return;
    for (uint face = 0u; face < 6u; ++face) {
        if (rx_material(cell + rx_face_step(face)) != 0u) continue;
        uint i = atomicAdd(lamps.count, 1u);
        if (i < 4096u) lamps.at[i] = ivec4(cell, int(material | (face << 16)));
    }
}
