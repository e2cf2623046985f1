// The frames of instances: the buffer's entry of each (instances.glsl), and the conversion of places and directions between its frame and
// the world. Nothing here traces.
#ifndef RAXEL_INSTANCE_FRAME_GLSL
#define RAXEL_INSTANCE_FRAME_GLSL

#include "ray.glsl"
#include "internal/walk.glsl"
#include "instance_block.glsl"

const uint RX_NO_INSTANCE = 0xffffffffu;
const uint RX_INSTANCE_QUADS = 8u;

// A ray through the world and its instances.
struct RxSceneRay {
    RxRay ray;     // in the world
    uint own;      // the free instance that it leaves, or RX_NO_INSTANCE
    RxRay start;   // in the frame of that instance: it begins on the plane of the face that it leaves, so there is no epsilon
};

// The frame in which a ray crosses an instance.
struct RxInstance {
    ivec3 corner;     // smallest corner of the cube of its tree: in the world, or counted from its anchor in its own frame
    uint shape;       // log2 of the size of that cube, turn from its cells to the model's << 8, free << 16
    ivec3 low;        // box of its solid voxels, from that corner
    ivec3 high;
    uint tree;        // first quad of its model
    uint root;        // the root, in nodes of the tree
    ivec3 model_corner;  // the corner in the model's own coordinates
    ivec3 cell;       // the centre of its anchor in the world
    uvec3 fraction;
    ivec3 row_x;      // of the rotation from the world's axes to the model's, in units of 2^-23
    ivec3 row_y;
    ivec3 row_z;
};

// An instance from its quads in the buffer.
RxInstance rx_instance_of_quads(uvec4 q[RX_INSTANCE_QUADS]) {
    return RxInstance(ivec3(q[0].xyz), q[0].w, ivec3(q[1].xyz), ivec3(q[2].xyz), q[1].w, q[2].w, ivec3(q[3].xyz), ivec3(q[4].xyz),
                      uvec3(q[3].w, q[4].w, q[5].w), ivec3(q[5].xyz), ivec3(q[6].xyz), ivec3(q[7].xyz));
}

// The instance of an index, in the order of the world's file.
RxInstance rx_instance_of(uint index) {
    uint at = instances.first + RX_INSTANCE_QUADS * index;
    uvec4 q[RX_INSTANCE_QUADS];
    for (uint i = 0u; i < RX_INSTANCE_QUADS; ++i) q[i] = instances.quads[at + i];
    return rx_instance_of_quads(q);
}

// Whether the instance is not on the lattice of the world.
bool rx_instance_is_free(RxInstance instance) {
    return ((instance.shape >> 16) & 1u) != 0u;
}

// The axis that an axis of the model becomes by the turn of the instance on the lattice.
uint rx_instance_axis(RxInstance instance, uint axis) {
    uint turn = instance.shape >> 8;
    uint x = turn & 3u, y = (turn >> 2) & 3u;
    return axis == 0u ? x : axis == 1u ? y : 3u - x - y;
}

// Whether the turn of an instance on the lattice reverses this axis.
bool rx_instance_turns_around(RxInstance instance, uint axis) {
    return ((instance.shape >> (12u + axis)) & 1u) != 0u;
}

// 64-bit integers as (low, high), two's complement, as in walk.glsl.
uvec2 rx_sum(uvec2 a, uvec2 b) {
    uint low = a.x + b.x;
    return uvec2(low, a.y + b.y + (low < a.x ? 1u : 0u));
}

// The product of two signed integers, in 64 bits.
uvec2 rx_signed_product(int a, int b) {
    int high, low;
    imulExtended(a, b, high, low);
    return uvec2(uint(low), uint(high));
}

// The dot product of two vectors of integers, in 64 bits.
uvec2 rx_dot(ivec3 a, ivec3 b) {
    return rx_sum(rx_sum(rx_signed_product(a.x, b.x), rx_signed_product(a.y, b.y)), rx_signed_product(a.z, b.z));
}

// Multiplies a row in units of 2^-23 by a place, which is cells and a rest in units of 2^-24, and adds half a voxel. `over` is the remainder in
// units of 2^-24, rounded down.
void rx_turned(ivec3 row, ivec3 cells, ivec3 rest, out int cell, out uint over) {
    uvec2 whole = rx_dot(row, cells);                                  // in 2^-23
    cell = int((whole.x >> 23) | (whole.y << 9));
    uint left = whole.x & 0x7fffffu;
    uvec2 sum = rx_sum(rx_dot(row, rest), uvec2(left << 24, left >> 8));  // in 2^-47
    sum = rx_sum(sum, uvec2(0u, 0x4000u));                             // half a voxel
    cell += int(sum.y) >> 15;
    over = ((sum.x >> 23) | (sum.y << 9)) & 0xffffffu;
}

// A direction in the axes of a free instance.
vec3 rx_direction_in_instance(RxInstance instance, vec3 dir) {
    vec3 x = vec3(instance.row_x) * 1.1920928955078125e-7, y = vec3(instance.row_y) * 1.1920928955078125e-7;
    vec3 z = vec3(instance.row_z) * 1.1920928955078125e-7;
    precise vec3 a = vec3(x.x, y.x, z.x) * dir.x;
    precise vec3 b = vec3(x.y, y.y, z.y) * dir.y;
    precise vec3 c = vec3(x.z, y.z, z.z) * dir.z;
    precise vec3 sum = a + b;
    precise vec3 turned = sum + c;
    return turned;
}

// A vector in the axes of a free instance, in those of the world.
vec3 rx_direction_from_instance(RxInstance instance, vec3 v) {
    return (vec3(instance.row_x) * v.x + vec3(instance.row_y) * v.y + vec3(instance.row_z) * v.z) * 1.1920928955078125e-7;
}

// A ray through the world and its instances that begins anywhere.
RxSceneRay rx_scene_ray(RxRay ray) {
    return RxSceneRay(ray, RX_NO_INSTANCE, ray);
}

// A ray in a direction of the world that starts in the frame of a free instance, whose number is `index`.
RxSceneRay rx_scene_ray_from_instance(RxInstance instance, uint index, RxRay start, vec3 dir) {
    // The transposed rows bring the place back; it is counted from the centre of the anchor.
    ivec3 column_x = ivec3(instance.row_x.x, instance.row_y.x, instance.row_z.x);
    ivec3 column_y = ivec3(instance.row_x.y, instance.row_y.y, instance.row_z.y);
    ivec3 column_z = ivec3(instance.row_x.z, instance.row_y.z, instance.row_z.z);
    ivec3 rest = ivec3(start.frac * 16777216.0) - 8388608;
    ivec3 cell;
    uvec3 over;
    rx_turned(column_x, start.cell, rest, cell.x, over.x);
    rx_turned(column_y, start.cell, rest, cell.y, over.y);
    rx_turned(column_z, start.cell, rest, cell.z, over.z);
    // rx_turned adds half a voxel.
    uvec3 sum = over + instance.fraction + 8388608u;
    RxRay ray = rx_ray(instance.cell + cell + ivec3(sum >> 24) - 1, vec3(sum & 0xffffffu) * 5.9604644775390625e-8, dir);
    return RxSceneRay(ray, index, start);
}

#endif
