// The frame's values for the passes of the examples. Graphs fill it once, as [blocks.frame]; a pass runs again when a member changes that
// its shader reads.
#ifndef EXAMPLES_FRAME_GLSL
#define EXAMPLES_FRAME_GLSL

layout(std140) uniform Frame {
    mat4 view_to_world;
    ivec3 camera_cell;
    float sun_azimuth;    // degrees
    vec3 camera_frac;
    float sun_elevation;  // degrees
    vec2 tan_half_fov;
    float exposure;
} frame;

#endif
