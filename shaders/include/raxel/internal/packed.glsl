// Materials of several voxels in few bits: a palette of 2^(2^kind) materials, two a word, then 2^kind bits for each voxel in turn. Kind 4
// has no palette, and the 16 bits are the material. Layouts whose leaves link to packed materials include this file.

// The material of voxel `rank` in a run that is packed from word `at` on.
uint rx_palette_material(uint at, uint kind, uint rank) {
    uint bit = rank << kind;
    if (kind == 4u) return (rx_word(at + (bit >> 5)) >> (bit & 31u)) & 0xffffu;
    uint bits = 1u << kind;
    uint palette_words = (1u << bits) >> 1;
    uint index = (rx_word(at + palette_words + (bit >> 5)) >> (bit & 31u)) & ((1u << bits) - 1u);
    return (rx_word(at + (index >> 1)) >> (16u * (index & 1u))) & 0xffffu;
}

// The material of voxel `rank` of a leaf. Its link has RX_UNIFORM and the only material; or the word of the packed materials (29 bits) and their
// kind in bits 29 and 31, 3 for kind 4.
uint rx_linked_material(uint link, uint rank) {
    if ((link & RX_UNIFORM) != 0u) return link & 0xffffu;
    uint code = ((link >> 30) & 2u) | ((link >> 29) & 1u);
    return rx_palette_material(link & 0x1fffffffu, code == 3u ? 4u : code, rank);
}
