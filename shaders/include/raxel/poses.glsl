// Lets shaders move instances: see [[instances]] in docs/world-file.md. Bind `poses` to a buffer with `source = "world.poses"`. The buffer is
// empty when a frame begins. An instance takes its written pose two frames later. It keeps the pose until a pass writes another one or
// returns the instance to its params, or until time starts over. Invocations may write in any order: if one frame has several poses for
// an instance, raxel always chooses the same one.
#ifndef RAXEL_POSES_GLSL
#define RAXEL_POSES_GLSL

layout(std430) buffer RxPoses {
    uint count;  // of written records; raxel drops those without room, with a warning
    uint unused0;
    uint unused1;
    uint unused2;
    uint records[];  // twelve words for each
} poses;

// The records of the functions below. The anchor's cell of the instance goes to `cell` + `place`, in voxels; `place` may be any finite
// numbers.
void rx_pose_record(uint kind, uint instance, ivec3 cell, vec3 place, vec4 turn) {
    uint index = atomicAdd(poses.count, 1u);
    if (index >= uint(poses.records.length()) / 12u) return;
    uint at = 12u * index;
    poses.records[at] = kind;
    poses.records[at + 1u] = instance;
    for (uint axis = 0u; axis < 3u; ++axis) {
        poses.records[at + 2u + axis] = uint(cell[axis]);
        poses.records[at + 5u + axis] = floatBitsToUint(place[axis]);
    }
    for (uint i = 0u; i < 4u; ++i) poses.records[at + 8u + i] = floatBitsToUint(turn[i]);
}

// Takes the values of the world's file: the number of the instance in the order of the file, from 0; its position; yaw, pitch and roll in
// degrees. Whole cells and multiples of 90 degrees keep it on the lattice of the world.
void rx_pose_set(uint instance, ivec3 cell, vec3 place, float yaw, float pitch, float roll) {
    rx_pose_record(1u, instance, cell, place, vec4(yaw, pitch, roll, 0.0));
}

// The same with a quaternion (x, y, z, w) of any length but zero, from the model's axes to the world's.
void rx_pose_set_quaternion(uint instance, ivec3 cell, vec3 place, vec4 quaternion) {
    rx_pose_record(2u, instance, cell, place, quaternion);
}

// The instance stands where the world's file and params put it.
void rx_pose_restore(uint instance) {
    rx_pose_record(0u, instance, ivec3(0), vec3(0.0), vec4(0.0));
}

#endif
