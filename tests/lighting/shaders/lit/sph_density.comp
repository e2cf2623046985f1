#version 460
#include <raxel/thread.glsl>
#include "live.glsl"
layout(local_size_x = 64) in;
layout(std430) buffer Particles { Particle particles[]; };
layout(std430) readonly buffer Heads { uint heads[]; };
layout(std430) readonly buffer Next { uint next[]; };
void main() {
    uint i = rx_thread();
    if (i >= PARTICLES) return;
    vec3 p = particles[i].p;
    float density = 0.0, near = 0.0;
    for (int n = 0; n < 27; ++n) {
        ivec3 c = ivec3(floor(p / H)) + ivec3(n % 3, n / 3 % 3, n / 9) - 1;
        if (any(lessThan(c, ivec3(0))) || any(greaterThanEqual(c, GRID))) continue;
        for (uint j = heads[c.x + GRID.x * (c.y + GRID.y * c.z)]; j != 0u; j = next[j - 1u]) {
            float q = 1.0 - distance(particles[j - 1u].p, p) / H;
            if (q > 0.0 && j != i + 1u) { density += q * q; near += q * q * q; }
        }
    }
    particles[i].density = density;
    particles[i].near = near;
}
