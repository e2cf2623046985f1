// Particles begin as a block; only where there are none yet.
#version 460
#include <raxel/thread.glsl>
#include "live.glsl"
layout(local_size_x = 64) in;
layout(std430) buffer Particles { Particle particles[]; };
layout(std430) buffer Heads { uint heads[]; };
layout(std430) writeonly buffer Next { uint next[]; };
layout(push_constant) uniform Push { float dt; } push;
void main() {
    uint i = rx_thread();
    if (i >= PARTICLES) return;
    Particle q = particles[i];
    if (q.p == vec3(0.0)) {
        ivec3 c = ivec3(i % 16u, i / 256u, i / 16u % 16u);
        q.p = vec3(14.0, 4.0, 14.0) + 1.9 * vec3(c) + 0.1 * fract(vec3(c) * vec3(0.37, 0.71, 0.13));
        q.before = q.p;
    }
    // Velocity, gravity, prediction (Clavet, Beaudoin and Poulin, "Particle-based viscoelastic fluid simulation", 2005).
    vec3 v = (q.p - q.before) / push.dt;
    v.y -= 60.0 * push.dt;
    v *= min(1.0, 110.0 / max(length(v), 1.0));
    q.before = q.p;
    q.p += push.dt * v;
    particles[i] = q;
    next[i] = atomicExchange(heads[cell_of(q.p)], i + 1u);
}
