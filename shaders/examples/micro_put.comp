// Puts the ball in front of the camera, once.
#version 460

layout(local_size_x = 1) in;
layout(std430) buffer Spot { ivec3 corner; uint put; } spot;
layout(push_constant) uniform Push { mat4 view_to_world; ivec3 camera_cell; } push;

void main() {
    if (spot.put != 0u) return;
    vec3 forward = (push.view_to_world * vec4(0.0, 0.0, -1.0, 0.0)).xyz;
    spot.corner = push.camera_cell + ivec3(round(22.0 * forward)) - 8;
    spot.put = 1u;
}
