// An item of the work, as a part of a face. Needs world.glsl, scene.glsl, face_table.glsl, unwrapped.glsl and work.glsl.
struct Item {
    ivec3 voxel;
    uint face;
    vec2 corner;   // of the part, on the face
    float side;
    uint slot;
    uint texel;    // NO_ITEM for a whole face
    uint seed;
};

bool item_at(uint index, out Item item) {
    uint word = items[index];
    if (word == NO_ITEM) return false;
    bool part = (word & TEXEL_ITEM) != 0u;
    item.texel = part ? word & ~TEXEL_ITEM : NO_ITEM;
    item.slot = part ? unwrapped.slot_of[item.texel >> 4] - 1u : word;
    // A block that was given on since then.
    if (item.slot == 0xffffffffu) return false;
    item.corner = part ? 0.25 * vec2(item.texel & 3u, item.texel >> 2 & 3u) : vec2(0.0);
    item.side = part ? 0.25 : 1.0;
    RxFaceKey key;
    if (!rx_face_in_slot(item.slot, key)) return false;
    uint unused;
    rx_face_of(key, face_box(), item.voxel, item.face, unused);
    // By the key, because slots and blocks depend on the order of threads.
    item.seed = scene_seed(rx_hash(key.home) ^ key.rest ^ (part ? (item.texel & 15u) + 1u : 0u) * 0x9e3779b9u);
    return true;
}
