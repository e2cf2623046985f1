#version 460
#include <raxel/random.glsl>
layout(local_size_x = 64) in;
layout(std430) buffer FaceKeys { uint face_keys[]; };
layout(std430) buffer Met { uint met[]; };
layout(std430) buffer Results { uint results[]; };
#define RX_FACE_INSERT
#include <raxel/light/face_table.glsl>

// Faces all over a large world whose smallest corner is far from zero. Neighbours in pairs: half of the threads repeat the others.
void main() {
    uint i = gl_GlobalInvocationID.x >> 1;
    const ivec3 origin = ivec3(-5000, 77, 123456);
    uint random = rx_hash(i);
    ivec3 voxel = origin + ivec3(i & 16383u, (i >> 14) * 500u + (random & 63u), random >> 6 & 16383u);
    uint face = (random >> 20) % 6u, part = (random >> 24) % 5u;
#ifdef RX_FACE_WHOLE
    part = 0u;
#endif
    RxFaceKey key = rx_face_key(voxel, face, part);
#if STAGE == 0
    ivec3 voxel_back;
    uint face_back, part_back;
    rx_face_of(key, origin, voxel_back, face_back, part_back);
    if (voxel_back != voxel || face_back != face || part_back != part || !rx_face_fits(voxel, origin)) atomicAdd(results[0], 1u);
    uint slot = rx_face_insert(key);
    if (slot == RX_NO_FACE) atomicAdd(results[1], 1u);
    else atomicAdd(met[slot], 1u);
#else
    uint slot = rx_face_find(key);
    RxFaceKey there;
    if (slot == RX_NO_FACE || !rx_face_in_slot(slot, there) || there != key) atomicAdd(results[2], 1u);
    else if (met[slot] != 2u) atomicAdd(results[3], 1u);
#endif
}
