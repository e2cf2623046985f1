// Depth, in voxels, of a share of the slices, and back. Half of them lie within 180 voxels.
float slice_depth(float share) {
    return 20.0 * (exp2(9.0 * share) - 1.0) * 0.4;
}

float slice_of(float depth) {
    return log2(depth / 8.0 + 1.0) / 9.0;
}

// The number that begins the random numbers of a slice: column, and index of the slice.
uint slice_seed(ivec3 slice) {
    return scene_seed(uint(slice.x) + rx_hash(uint(slice.y) + 4711u)) + uint(slice.z);
}

// The `index`-th depth of those where a slice is asked for its light. `size` is the number of columns and slices.
float slice_place(ivec3 slice, ivec3 size, uint index) {
    float near = slice_depth(float(slice.z) / float(size.z)), far = slice_depth(float(slice.z + 1) / float(size.z));
    return mix(near, far, rx_sobol(index, 0u, rx_hash(slice_seed(slice))).x);
}
