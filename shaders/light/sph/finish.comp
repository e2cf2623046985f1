// End of a tick: speeds from the ways that particles came, each drawn towards those around it (viscosity, Schechter and Bridson 2012).
#version 460
#include "water.glsl"
#include "neighbours.glsl"

layout(local_size_x = 64) in;
layout(std430) readonly buffer Starts { uint starts[]; };
layout(std430) readonly buffer Sorted { Particle sorted[]; };
layout(std430) writeonly buffer Particles { Particle particles[]; };
layout(push_constant) uniform Push { float delta; float viscosity; } push;

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= sorted.length()) return;
    Particle me = sorted[i];
    vec3 way = me.at - me.speed, drawn = vec3(0.0);
    FOR_NEIGHBOURS(me.cell, {
        vec3 from = me.at - sorted[j].at;
        drawn += kernel(dot(from, from)) / REST * (sorted[j].at - sorted[j].speed - way);
    })
    me.speed = (way + push.viscosity * drawn) / push.delta;
    particles[i] = me;
}
