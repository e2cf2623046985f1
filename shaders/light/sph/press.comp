// The pressure that would bring the density of each particle back to that at rest, in the paper's terms lambda. Water pushes and does not pull.
#version 460
#include "water.glsl"
#include "neighbours.glsl"

layout(local_size_x = 64) in;
layout(std430) readonly buffer Starts { uint starts[]; };
layout(std430) readonly buffer Sorted { Particle sorted[]; };
layout(std430) writeonly buffer Pressures { vec2 pressures[]; };   // lambda, density in parts of that at rest

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= sorted.length()) return;
    vec3 at = sorted[i].at, own = vec3(0.0), wall;
    float sum = 0.0, squares = 0.0;
    FOR_NEIGHBOURS(sorted[i].cell, {
        vec3 from = at - sorted[j].at;
        float square = dot(from, from);
        if (square < REACH * REACH) {
            sum += kernel(square);
            vec3 slope = kernel_slope(from) / REST;
            own += slope;
            squares += dot(slope, slope);
        }
    })
    float density = sum / REST + density_of_walls(at, wall);
    own += wall;
    squares += dot(own, own);
    pressures[i] = vec2(-max(density - 1.0, 0.0) / (squares + SOFT), density);
}
