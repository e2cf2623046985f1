#version 460
#include <raxel/thread.glsl>
#include "live.glsl"
layout(local_size_x = 64) in;
layout(std430) readonly buffer Particles { Particle particles[]; };
layout(std430) writeonly buffer Moved { Particle moved[]; };
layout(std430) readonly buffer Heads { uint heads[]; };
layout(std430) readonly buffer Next { uint next[]; };
uniform usampler3D still;
layout(push_constant) uniform Push { float dt; } push;
bool solid(vec3 p) { return texelFetch(still, clamp(ivec3(floor(p)), ivec3(0), textureSize(still, 0) - 1), 0).x != 0u; }
void main() {
    uint i = rx_thread();
    if (i >= PARTICLES) return;
    Particle me = particles[i];
    vec3 shift = vec3(0.0);
    for (int n = 0; n < 27; ++n) {
        ivec3 c = ivec3(floor(me.p / H)) + ivec3(n % 3, n / 3 % 3, n / 9) - 1;
        if (any(lessThan(c, ivec3(0))) || any(greaterThanEqual(c, GRID))) continue;
        for (uint j = heads[c.x + GRID.x * (c.y + GRID.y * c.z)]; j != 0u; j = next[j - 1u]) {
            if (j == i + 1u) continue;
            Particle other = particles[j - 1u];
            vec3 d = me.p - other.p;
            float r = length(d), q = 1.0 - r / H;
            if (q <= 0.0) continue;
            float pressure = 0.5 * 900.0 * (me.density + other.density - 2.0 * 4.0), close = 0.5 * 1500.0 * (me.near + other.near);
            shift += push.dt * push.dt * (pressure * q + close * q * q) * (r > 1e-4 ? d / r : vec3(0.0, 1.0, 0.0)) * 0.25;
            // A little viscosity: towards the others' way.
            shift += 0.01 * q * ((other.p - other.before) - (me.p - me.before));
        }
    }
    shift *= min(1.0, 1.0 / max(length(shift), 1e-6));
    vec3 p = me.p + shift;
    // Voxels push back, axis by axis.
    vec3 from = me.before;
    for (int axis = 0; axis < 3; ++axis) {
        vec3 to = from;
        to[axis] = p[axis];
        if (solid(to)) to[axis] = from[axis];
        from = to;
    }
    me.p = clamp(from, vec3(1.0), vec3(127.0, 63.0, 127.0));
    moved[i] = me;
}
