// N probes x 64 rays: a workgroup a probe.
#version 460
#include <raxel/world.glsl>
#include "lum.glsl"
layout(local_size_x = 64) in;
uniform sampler3D before;
uniform sampler2D sunMap;
layout(rgba16f) uniform writeonly image3D outProbes;
layout(push_constant) uniform Push { float reach; float blend; uint tick; } push;
shared vec4 sums[64];
void main() {
    ivec3 at = ivec3(gl_WorkGroupID);
    uint i = gl_LocalInvocationIndex;
    uint seed = rx_hash(rx_hash(at) + 64u * frame.index + i);
    vec3 sun = rx_sun_direction(frame.sun_azimuth, frame.sun_elevation);
    // Stratified: a spiral over the sphere, turned at random.
    float z = 1.0 - (2.0 * float(i) + 2.0 * rx_random(seed)) / 64.0, a = 2.399963 * float(i) + 6.2832 * float(rx_hash(frame.index) >> 8) * 5.96e-8;
    vec3 dir = vec3(sqrt(max(0.0, 1.0 - z * z)) * vec2(cos(a), sin(a)), z);
    ivec3 cell = frame.world_min + 16 * at + 8;
    // Somewhere in the block, so that probes in walls see something.
    vec3 off = vec3(rx_random(seed), rx_random(seed), rx_random(seed)) * 16.0 - 8.0;
    cell += ivec3(floor(off));
    RxRay ray = rx_ray(cell, fract(off), dir);
    ray.t_max = push.reach;
    RxHit hit;
    bool found = rx_trace(ray, hit);
    vec4 light = vec4(0.0, 0.0, 0.0, 1.0);
    if (found && hit.face == RX_FACE_INSIDE) light.a = 0.0;
    else if (found) {
        RxMaterial m = rx_material_properties(hit.material);
        vec3 n = rx_normal(hit.face), p = rel(hit.voxel, hit.face, hit.uv);
        float lit = max(dot(n, sun), 0.0);
        if (lit > 0.0) lit *= sun_map(sunMap, p + 0.5 * n, sun, 0.5);
        vec3 in_light = 2.3 * lit * rx_sun_color(sun) + field(before, p + 8.0 * n);
        light.rgb = m.albedo * (in_light + m.emission);
    } else {
        // Nothing within reach: what the probes at the ray's end have, or the sky out of the world.
        vec3 end = vec3(cell - frame.world_min) + fract(off) + push.reach * dir;
        vec3 box = 16.0 * vec3(imageSize(outProbes));
        bool within = all(greaterThan(end, vec3(0.0))) && all(lessThan(end, box));
        light.rgb = within ? field(before, end) : 0.9 * rx_sky(dir, sun);
    }
    light.rgb *= light.a;
    sums[i] = light;
    for (uint s = 32u; s > 0u; s >>= 1) {
        barrier();
        if (i < s) sums[i] += sums[i + s];
    }
    if (i == 0u) {
        vec4 old = texelFetch(before, at, 0), now = sums[0] / 64.0;
        imageStore(outProbes, at, push.tick == 0u ? now : mix(old, now, push.blend));
    }
}
