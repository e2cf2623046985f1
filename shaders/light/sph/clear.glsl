// The material of water in a world: the first clear one, or the first of all.
uint clear_material() {
    for (uint i = 1u; i < world.material_count; ++i) {
        if (rx_material_properties(i).transparency > 0.0) return i;
    }
    return 1u;
}
