// The model's voxel at a cell of the world, 0 for none: the cell's centre, turned back. Needs <raxel/world/model.glsl>.
uint model_cell(Placed placed, ivec3 cell) {
    vec3 d = transpose(placed.axes) * (vec3(cell) + 0.5 - placed.at);
    vec3 floor_middle = vec3(0.5 * vec3(model.bounds_min + model.bounds_last + 1));
    floor_middle.y = float(model.bounds_min.y);
    return model_material(ivec3(floor(d + floor_middle)));
}
