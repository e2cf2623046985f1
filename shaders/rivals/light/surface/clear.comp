// Before the items of a frame are counted.
#version 460
#define WORK_ACCESS
#include "work.glsl"
layout(local_size_x = 1) in;

void main() {
    work.count = 0u;
    work.wanted = 0u;
    work.taken = 0u;
}
