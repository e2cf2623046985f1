// A ball is dug out of the copy of the world.
#version 460
#define RX_WRITE_world
#include <raxel/world.glsl>
layout(local_size_x = 4, local_size_y = 4, local_size_z = 4) in;
layout(push_constant) uniform Push { ivec3 centre; int radius; } push;
void main() {
    ivec3 d = ivec3(gl_GlobalInvocationID) - push.radius;
    if (dot(d, d) < push.radius * push.radius) rx_set(push.centre + d, 0u);
}
