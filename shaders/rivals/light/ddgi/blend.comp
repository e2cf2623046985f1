// The new rays go into the probes: a thread for each of a probe's 64 directions. The first six also take one face direction each.
#version 460
#include <raxel/ray.glsl>
#include <raxel/thread.glsl>
#include "light/scene.glsl"
#include "light/change.glsl"
#define PROBE_ACCESS
#include "probes.glsl"

layout(local_size_x = 64) in;
layout(std430) readonly buffer Rays { vec4 rays[]; };
layout(push_constant) uniform Push { float hysteresis; } push;

void main() {
    int thread = int(rx_thread());
    ivec3 n = probe_counts();
    if (thread >= n.x * n.y * n.z * 64) return;
    int probe = thread / 64, texel = thread % 64;
    vec3 towards = depth_direction(texel), normal = rx_normal(uint(min(texel, 5))), light = vec3(0.0);
    vec3 depth = vec3(0.0);
    for (int i = 0; i < PROBE_RAYS; ++i) {
        vec4 ray = rays[probe * PROBE_RAYS + i];
        vec3 dir = ray_direction(i, frame.index);
        light += ray.rgb * max(dot(dir, normal), 0.0);
        // A narrow lobe, so that a wall's edge stays where it is.
        float w = pow(max(dot(dir, towards), 0.0), 40.0), d = min(ray.w, PROBE_FAR);
        depth += w * vec3(d, d * d, 1.0);
    }
    float frames = probes[6 * probe + min(texel, 5)].w;
    // Until there are enough frames, all count the same.
    float stays = min(push.hysteresis, frames / (frames + 1.0));
    if (state.changed != 0u) stays = min(stays, 0.5);
    vec2 old = depths[thread];
    if (depth.z > 1e-4) depths[thread] = old == vec2(0.0) ? depth.xy / depth.z : mix(depth.xy / depth.z, old, min(push.hysteresis, 0.97));
    barrier();
    if (texel < 6) {
        vec4 kept = probes[6 * probe + texel];
        probes[6 * probe + texel] = vec4(mix(4.0 / float(PROBE_RAYS) * light, kept.rgb, stays), frames + 1.0);
    }
}
