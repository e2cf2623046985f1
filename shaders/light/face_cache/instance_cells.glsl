// The key of the table for the light of a place on an instance: that of a face of a voxel of its model, in any pose. So the light moves with the
// instance. Faces that are narrow on the picture, and those of models of more than 256 voxels, share the key of a cell of the model. Keys of the
// world's faces leave four values of face and part free: these keys have them. 14 bits are the number of the instance. Each coordinate of the
// cell has 8 bits. Part of cells.glsl; voxels and cells are as <raxel/scene.glsl> has them.

const uint INSTANCE_CELL = CELL_PARTS + 4u;   // the part of cells; faces have 0
const uint INSTANCE_KEYS = 60u;               // the first of those four values
const uint INSTANCE_LOG2 = 8u;                // of the cells of a model along an axis, at most

// log2 of the width of a cell or face, in voxels of the model.
uint instance_cell_log2(ivec3 voxel, uint part) {
    if (part == 0u) return 0u;
    uint log2_size = rx_instance_of(rx_place_instance(voxel)).shape & 31u;
    return max(2u, max(log2_size, INSTANCE_LOG2) - INSTANCE_LOG2);
}

ivec3 instance_cell_of(ivec3 voxel, uint part) {
    ivec3 cell = rx_place_cell(voxel) >> int(instance_cell_log2(voxel, part));
    cell.x |= int(rx_place_instance(voxel) << RX_PLACE_BITS);
    return cell;
}

RxFaceKey instance_cell_key(ivec3 cell, uint face, uint part) {
    uvec3 c = uvec3(rx_place_cell(cell));
    uint kind = RX_FACE_PART(face) + (part == 0u ? 0u : 6u);
    uint home = c.x | c.y << 8 | (c.z & 15u) << 16;
    uint rest = c.z >> 4 | rx_place_instance(cell) << 4 | (kind & 3u) << 18 | INSTANCE_KEYS + (kind >> 2) << 20;
    return rx_face_mixed(home, rest);
}

// False if it is the key of a place in the world.
bool instance_cell_of_key(RxFaceKey key, out ivec3 cell, out uint face, out uint part) {
    rx_face_unmix(key);
    uint kind = (key.rest >> 20) - INSTANCE_KEYS << 2 | key.rest >> 18 & 3u;
    cell = ivec3(key.home & 255u, key.home >> 8 & 255u, key.home >> 16 | (key.rest & 15u) << 4);
    cell.x |= int((key.rest >> 4 & 16383u) << RX_PLACE_BITS);
    face = kind % 6u | RX_ON_INSTANCE;
    part = kind < 6u ? 0u : INSTANCE_CELL;
    return key.rest >> 20 >= INSTANCE_KEYS;
}

// The cell `step` cells further in the model; false if its cube ends before.
bool instance_cell_beside(ivec3 cell, ivec3 step, out ivec3 other) {
    ivec3 there = rx_place_cell(cell) + step;
    other = there;
    other.x |= int(rx_place_instance(cell) << RX_PLACE_BITS);
    return ((there.x | there.y | there.z) >> int(INSTANCE_LOG2)) == 0;
}

vec2 instance_cell_place(ivec3 voxel, uint face, vec2 uv, uint part) {
    int log2_width = int(instance_cell_log2(voxel, part));
    ivec3 cell = rx_place_cell(voxel);
    return (rx_face_uv(RX_FACE_PART(face), vec3(cell - (cell >> log2_width << log2_width))) + uv) / float(1 << log2_width);
}

float instance_cell_pixels(ivec3 cell, uint face, uint part, float height) {
    uint log2_width = instance_cell_log2(cell, part);
    ivec3 middle = (rx_place_cell(cell) << int(log2_width)) + (1 << int(log2_width) >> 1);
    middle.x |= int(rx_place_instance(cell) << RX_PLACE_BITS);
    return float(1u << log2_width) * pixels_from(face_middle(middle, face), height);
}

uint instance_cell_part(ivec3 voxel, float width, float grain) {
    uint log2_size = rx_instance_of(rx_place_instance(voxel)).shape & 31u;
    return width >= grain && log2_size <= INSTANCE_LOG2 ? 0u : INSTANCE_CELL;
}
