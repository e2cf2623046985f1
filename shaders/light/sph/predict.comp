// Begin of a tick: gravity, and where each particle would come without pressure; counts the particles of each cell. In the first tick they stand as a
// column over a corner of the box.
#version 460
#include <raxel/random.glsl>
#include "water.glsl"

layout(local_size_x = 64) in;
layout(std430) buffer Particles { Particle particles[]; };
layout(std430) buffer Counts { uint counts[]; };
layout(push_constant) uniform Push { uint tick; float delta; float gravity; } push;

const float FASTEST = 60.0;   // voxels a second: one a tick

// As high as the box allows, over at least two fifths of its width.
vec3 start(uint i) {
    uvec3 most = uvec3(vec3(box_size() - 1) / SPACING);
    uint wide = clamp((uint(particles.length()) + most.y * most.z - 1u) / (most.y * most.z), 2u * most.x / 5u, most.x);
    vec3 at = vec3(i % wide, i / wide / most.z, i / wide % most.z);
    uint seed = rx_hash(i);
    // A little disorder, or the column stands like a stack of plates.
    return 0.5 + SPACING * (at + 0.1 * vec3(rx_random(seed), rx_random(seed), rx_random(seed)));
}

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= particles.length()) return;
    Particle me = particles[i];
    if (push.tick == 0u) {
        me.speed = vec3(0.0);
        me.at = clamp(start(i), vec3(MARGIN), vec3(box_size()) - MARGIN);
    }
    vec3 speed = me.speed - vec3(0.0, push.gravity * push.delta, 0.0);
    speed *= min(1.0, FASTEST / max(length(speed), 1e-6));
    vec3 from = me.at;
    me.at = kept_out(from, from + push.delta * speed);
    me.speed = from;
    me.cell = grid_index(cell_at(me.at));
    atomicAdd(counts[me.cell], 1u);
    particles[i] = me;
}
