// Moves each particle along the differences of pressure.
#version 460
#include "water.glsl"
#include "neighbours.glsl"

layout(local_size_x = 64) in;
layout(std430) readonly buffer Starts { uint starts[]; };
layout(std430) readonly buffer Sorted { Particle sorted[]; };
layout(std430) readonly buffer Pressures { vec2 pressures[]; };
layout(std430) writeonly buffer Shifted { Particle shifted[]; };
layout(push_constant) uniform Push { float pressure; } push;

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= sorted.length()) return;
    Particle me = sorted[i];
    vec3 shift = vec3(0.0), wall;
    float mine = pressures[i].x;
    FOR_NEIGHBOURS(me.cell, {
        vec3 from = me.at - sorted[j].at;
        if (dot(from, from) < REACH * REACH) shift += (mine + pressures[j].x) * kernel_slope(from) / REST;
    })
    density_of_walls(me.at, wall);
    shift += mine * wall;
    me.density = pressures[i].y;
    me.at = kept_out(me.at, me.at + push.pressure * shift);
    shifted[i] = me;
}
