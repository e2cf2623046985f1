// Voxels of a writable copy that lie two in a word, for rx_set of the layouts `chunks` and `chunk_table`.

// Makes the half of a word (0 or 1) a material, and leaves the other half to the threads that write it. Of threads that write the
// same half at once, one wins. False if the other half changed so often meanwhile that it was given up.
bool rx_store_voxel(uint at, uint half_word, uint material) {
    uint shift = 16u * half_word;
    uint mask = 0xffffu << shift;
    uint known = world.words[at];
    // The limit is never met unless another thread writes the other half without end.
    for (uint i = 0u; i < 65535u; ++i) {
        uint found = atomicCompSwap(world.words[at], known, (known & ~mask) | (material << shift & mask));
        // Another thread's voxel may come after this one.
        if (((found ^ known) & mask) != 0u || found == known) return true;
        known = found;
    }
    return false;
}
