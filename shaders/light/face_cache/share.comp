// Decides how many paths each listed face gets, so that the total is about the requested number.
#version 460
#include <raxel/light/lights.glsl>

layout(local_size_x = 1) in;
#define QUEUE_ACCESS
#include "queue.glsl"
layout(push_constant) uniform Push { ivec2 size; float paths; } push;

void main() {
    uint budget = uint(clamp(push.paths, 0.0, 2.0) * float(push.size.x * push.size.y));
    queue.per_face = clamp(budget / max(queue.count, 1u), 1u, 8u);
    queue.lamps = rx_lights_count();
    queue.work = queue.count * queue.per_face;
}
