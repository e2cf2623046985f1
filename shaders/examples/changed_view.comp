// Compares the camera with that of the frame before. A pass of its own, since no invocation may look while another one writes.
#version 460
#include "changed.glsl"

layout(local_size_x = 1) in;
layout(std430) buffer View { Camera view; };
layout(std430) writeonly buffer Count { uint made; };

void main() {
    bool moved = view.view_to_world != frame.view_to_world || view.cell != frame.camera_cell || view.frac != frame.camera_frac
        || view.tan_half_fov != frame.tan_half_fov;
    view = Camera(frame.view_to_world, frame.camera_cell, frame.camera_frac, frame.tan_half_fov, moved ? 1u : 0u);
    made = 0u;
}
