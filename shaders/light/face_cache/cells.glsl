// Finds the key of the table that keeps the light of a place. A face that is wide on the picture is kept in quarters, one that is at least as wide
// as fit.grain as a whole. Smaller faces of one direction share the key of a cell. The cell is a cube of 2, 4, 8, 16 or 64 voxels: the first
// that is as wide as the grain. This follows from the face and the camera alone, so all askers agree. The light of a cell comes from places in
// it that pixels see: a hidden side of a thin wall adds nothing to it. Light on an instance has the key of a voxel of its model
// (instance_cells.glsl). Needs <raxel/light/face_table.glsl>, box.glsl and across.glsl.
#ifndef FACE_CACHE_CELLS_GLSL
#define FACE_CACHE_CELLS_GLSL

const uint CELL_PARTS = 5u;   // parts from here on are cells

// log2 of the width of a part's cell, in voxels: 0 for faces and their quarters.
uint cell_log2(uint part) {
    return part < CELL_PARTS ? 0u : part == CELL_PARTS + 4u ? 6u : part - CELL_PARTS + 1u;
}

#ifdef RX_BINDS_instances
#include "instance_cells.glsl"
#endif

// The cell, or the voxel itself.
ivec3 cell_of(ivec3 voxel, uint face, uint part) {
#ifdef RX_BINDS_instances
    if (rx_is_on_instance(face)) return instance_cell_of(voxel, part);
#endif
    return voxel >> int(cell_log2(part));
}

RxFaceKey cell_key(ivec3 cell, uint face, uint part) {
#ifdef RX_BINDS_instances
    if (rx_is_on_instance(face)) return instance_cell_key(cell, face, part);
#endif
    return rx_face_key(cell, face, part);
}

// Whether a cell has a key.
bool cell_fits(ivec3 cell, uint face, uint part) {
#ifdef RX_BINDS_instances
    if (rx_is_on_instance(face)) return true;
#endif
    return rx_face_fits(cell, face_box(cell_log2(part)));
}

// The parts of a key.
void cell_of_key(RxFaceKey key, out ivec3 cell, out uint face, out uint part) {
#ifdef RX_BINDS_instances
    if (instance_cell_of_key(key, cell, face, part)) return;
#endif
    ivec3 left;
    rx_face_of(key, ivec3(0), left, face, part);
    ivec3 origin = face_box(cell_log2(part));
    cell = origin + ivec3(uvec3(left - origin) & RX_FACE_LEFT);
}

// A place on the face of a voxel as one on the side of its cell or part, from 0 to 1.
vec2 cell_place(ivec3 voxel, uint face, vec2 uv, uint part) {
    if (part < CELL_PARTS) {
        vec3 corner = rx_face_part(part);
        return (uv - corner.xy) / corner.z;
    }
#ifdef RX_BINDS_instances
    if (rx_is_on_instance(face)) return instance_cell_place(voxel, face, uv, part);
#endif
    uint log2_width = cell_log2(part);
    vec3 inside = vec3(voxel - (voxel >> int(log2_width) << int(log2_width)));
    uint axis = rx_face_axis(face);
    vec2 corner = axis == 0u ? inside.yz : axis == 1u ? inside.xz : inside.xy;
    return (corner + uv) / float(1u << log2_width);
}

// Pixels across the side of a cell, from the distance of its centre.
float cell_pixels(ivec3 cell, uint face, uint part, float height) {
#ifdef RX_BINDS_instances
    if (rx_is_on_instance(face)) return instance_cell_pixels(cell, face, part, height);
#endif
    uint log2_width = cell_log2(part);
    float width = float(1u << log2_width);
    vec3 middle = vec3((cell << int(log2_width)) - frame.camera_cell) - frame.camera_frac + width * (0.5 + 0.5 * rx_normal(face));
    return width * pixels_from(middle, height);
}

// Pixels across a square that covers as much of the picture as the face. A face that looks away covers less.
float cell_width(ivec3 voxel, uint face, float height) {
    vec3 middle = face_middle(voxel, face);
    float away = max(length(middle), 1e-3), facing = abs(dot(middle, rx_place_normal(voxel, face))) / away;
    return pixels_from(middle, height) * sqrt(clamp(facing, 0.0625, 1.0));
}

// The part for a face of this width, if it is not kept in quarters.
uint cell_part(ivec3 voxel, uint face, float width, float grain) {
#ifdef RX_BINDS_instances
    if (rx_is_on_instance(face)) return instance_cell_part(voxel, width, grain);
#endif
    if (width >= grain) return 0u;
    for (uint part = CELL_PARTS; part < CELL_PARTS + 4u; ++part) {
        if (width * float(1u << cell_log2(part)) >= grain) return part;
    }
    return CELL_PARTS + 4u;
}

// The next wider part, for a face that found no slot.
uint cell_wider(uint face, uint part) {
    if (rx_is_on_instance(face)) return CELL_PARTS + 4u;
    return part < CELL_PARTS ? CELL_PARTS : part + 1u;
}

#endif
