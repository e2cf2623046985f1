// Maps an instance to its place in the world, and a cell of the world to a voxel of the instance. A freely turned instance covers
// each cell whose middle lies in one of its voxels.
#include <raxel/instance_voxels.glsl>

// The middle of its anchor, from the smallest corner of the world.
vec3 anchor_of(RxInstance instance) {
    return vec3(instance.cell - grid.world_min) + vec3(instance.fraction) * 5.9604644775390625e-8;
}

// The box around its solid voxels, from the smallest corner of the world; `high` is the first cell behind it.
void box_of(RxInstance instance, out ivec3 low, out ivec3 high) {
    ivec3 first = instance.corner + instance.low, behind = instance.corner + instance.high + 1;
    if (!rx_instance_is_free(instance)) {
        low = first - grid.world_min;
        high = behind - grid.world_min;
        return;
    }
    vec3 half_size = 0.5 * vec3(behind - first);
    vec3 middle = anchor_of(instance) + rx_direction_from_instance(instance, vec3(first) + half_size - 0.5);
    vec3 reach = (abs(vec3(instance.row_x)) * half_size.x + abs(vec3(instance.row_y)) * half_size.y + abs(vec3(instance.row_z)) * half_size.z)
        * 1.1920928955078125e-7;
    low = ivec3(floor(middle - reach));
    high = ivec3(ceil(middle + reach));
}

// The material of an instance at a cell of the world, counted from the world's smallest corner; 0 for none.
uint material_of(RxInstance instance, ivec3 cell) {
    ivec3 own = cell + grid.world_min;
    if (rx_instance_is_free(instance)) own = ivec3(floor(rx_direction_in_instance(instance, vec3(cell) + 0.5 - anchor_of(instance)) + 0.5));
    own -= instance.corner;
    if (any(lessThan(own, instance.low)) || any(greaterThan(own, instance.high))) return 0u;
    uint log2_free;
    return rx_instance_look(instance, rx_instance_cell(instance, uvec3(own)), log2_free);
}
