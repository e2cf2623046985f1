// The world as it is where nothing moves: that of the file, with grass on it. Needs <raxel/world/still.glsl> and GRASS_CELL.
uint still_cell(ivec3 cell, uint grass) {
    uint material = still_material(cell);
    return material == 0u && still_material(cell - ivec3(0, 1, 0)) == grass ? GRASS_CELL : material;
}
