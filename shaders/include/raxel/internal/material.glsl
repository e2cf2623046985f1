// Materials of a bound world. Included by the layouts, after the block that holds them.

// A word of the world, from the first one behind the header. The layout that reads four at a time defines RX_QUADS.
uint rx_word(uint at) {
#ifdef RX_QUADS
    return world.quads[at >> 2][at & 3u];
#else
    return world.words[at];
#endif
}

// The properties of a material; an unknown index is pink. A material has 8 words: albedo, roughness, metallic, emission, transparency, one unused.
RxMaterial rx_material_properties(uint material) {
    if (material >= world.material_count) return RxMaterial(vec3(1.0, 0.0, 0.5), 1.0, 0.0, 0.0, 0.0);
    uint at = world.materials_at + 8u * material;
    float word[7];
    for (uint i = 0u; i < 7u; ++i) word[i] = uintBitsToFloat(rx_word(at + i));
    return RxMaterial(vec3(word[0], word[1], word[2]), word[3], word[4], word[5], word[6]);
}
