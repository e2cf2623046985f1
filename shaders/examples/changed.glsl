// The frame's values for the passes of graphs/examples/changed.toml.
#ifndef EXAMPLES_CHANGED_GLSL
#define EXAMPLES_CHANGED_GLSL

layout(std140) uniform Frame {
    mat4 view_to_world;
    ivec3 camera_cell;
    vec3 camera_frac;
    vec2 tan_half_fov;
    ivec3 changed_min;  // voxels
    ivec3 changed_max;  // one past the last
} frame;

// A camera, and whether it is another one than that of the frame before.
struct Camera {
    mat4 view_to_world;
    ivec3 cell;
    vec3 frac;
    vec2 tan_half_fov;
    uint moved;
};

#endif
