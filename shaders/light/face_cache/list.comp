// Cuts the list to the entries that fit, and notes how many lamps there are.
#version 460
#include <raxel/light/lights.glsl>

layout(local_size_x = 1) in;
#define QUEUE_ACCESS
#include "queue.glsl"
layout(push_constant) uniform Push { ivec2 size; } push;

void main() {
    queue.count = min(queue.count, queue_room(push.size));
    queue.lamps = rx_lights_count();
}
