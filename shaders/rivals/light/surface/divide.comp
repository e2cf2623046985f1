// Decides how many paths each item gets, so that the total is about the requested number.
#version 460
#define WORK_ACCESS
#include "work.glsl"
layout(local_size_x = 1) in;
layout(push_constant) uniform Push { ivec2 size; float paths; } push;

void main() {
    work.count = min(work.count, items.length());
    uint budget = uint(clamp(push.paths, 0.0, 2.0) * float(push.size.x * push.size.y));
    work.per_item = clamp(budget / max(work.count, 1u), 1u, 8u);
    work.paths = work.count * work.per_item;
}
