#version 460
#include <raxel/thread.glsl>
#include "live.glsl"
layout(local_size_x = 64) in;
layout(std430) readonly buffer Moved { Particle moved[]; };
layout(std430) writeonly buffer Particles { Particle particles[]; };
layout(r16ui) uniform uimage3D live;
layout(push_constant) uniform Push { uint water; } push;
void main() {
    uint i = rx_thread();
    if (i >= PARTICLES) return;
    Particle q = moved[i];
    particles[i] = q;
    ivec3 corner = ivec3(floor(q.p - 0.5));
    for (int n = 0; n < 8; ++n) {
        ivec3 at = clamp(corner + ivec3(n & 1, (n >> 1) & 1, n >> 2), ivec3(0), imageSize(live) - 1);
        if (imageLoad(live, at).x == 0u) imageStore(live, at, uvec4(push.water));
    }
}
