// A thread for each texel of each listed face.
#version 460
#define QUEUE_ACCESS
#include "light/face_cache/queue.glsl"
layout(local_size_x = 1) in;

void main() {
    queue.work = 16u * queue.count;
}
