// How many paths fill the cells in this frame: one for each tile of the picture.
#version 460
layout(local_size_x = 1) in;
#define QUEUE_ACCESS
#include "light/face_cache/queue.glsl"
layout(push_constant) uniform Push { ivec2 size; int tile; } push;

void main() {
    ivec2 tiles = (push.size + push.tile - 1) / push.tile;
    queue.work = uint(tiles.x * tiles.y);
}
