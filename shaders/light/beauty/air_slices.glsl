// Depth, in voxels, of a share of the slices, and back. Half of them lie within 180 voxels.
float slice_depth(float share) {
    return 20.0 * (exp2(9.0 * share) - 1.0) * 0.4;
}

float slice_of(float depth) {
    return log2(depth / 8.0 + 1.0) / 9.0;
}
