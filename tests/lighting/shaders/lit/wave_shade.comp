#version 460
#include <raxel/world.glsl>
#include <raxel/thread.glsl>
#include "wave.glsl"
layout(local_size_x = 64) in;
layout(std430) readonly buffer Queue { uint count; uint bins[BINS]; } queue;
layout(std430) readonly buffer Order { uint order[]; };
layout(std430) readonly buffer Paths { Path paths[]; };
layout(std430) readonly buffer Hits { Hit hits[]; };
layout(std430) buffer Light { vec4 light[]; };
layout(std430) buffer Next { uint count; uint bins[BINS]; } next;
layout(std430) writeonly buffer NextPaths { Path next_paths[]; };
layout(std430) readonly buffer Lamps { uint count; uint pad[3]; ivec4 at[]; } lamps;
layout(push_constant) uniform Push { int bounce; int bounces; } push;
void main() {
    uint i = rx_thread();
    if (i >= queue.count) return;
    uint id = order[i];
    Path path = paths[id];
    ivec4 hit = hits[id].at;
    vec2 uv = intBitsToFloat(hits[id].uv.xy);
    vec3 sun = rx_sun_direction(frame.sun_azimuth, frame.sun_elevation);
    if (hit.w < 0) {
        light[path.pixel].rgb += path.share * (push.bounce == 0 ? rx_sky_with_sun(path.dir, sun) : 0.9 * rx_sky(path.dir, sun));
        return;
    }
    uint face = hit_face(hit.w);
    if (face == RX_FACE_INSIDE) return;
    RxMaterial m = rx_material_properties(hit_material(hit.w));
    // Lamps are asked for by name below, but for what a mirror shows.
    if (push.bounce == 0 || path.pad == 1u) light[path.pixel].rgb += path.share * m.albedo * m.emission;
    if (push.bounce == push.bounces - 1 || m.emission > 0.0) return;
    vec3 n = rx_normal(face), v = -path.dir;
    uint seed = path.seed;
    // The sun and a lamp, by rays of their own; one loop, so that the tracer is compiled once.
    uint lamp_count = min(lamps.count, 4096u);
    for (int turn = 0; turn < 2; ++turn) {
        vec3 dir, power;
        RxRay ray;
        if (turn == 0) {
            dir = around(sun, 0.012, seed);
            power = 2.3 * PI * rx_sun_color(sun);
            ray = rx_ray_from_face(hit.xyz, face, uv, dir);
        } else {
            if (lamp_count == 0u) break;
            ivec4 lamp = lamps.at[rx_random_uint(seed) % lamp_count];
            vec3 ln = rx_normal(hit_face(lamp.w));
            ivec3 t, b;
            rx_face_tangents(hit_face(lamp.w), t, b);
            ray = rx_ray_from_face(hit.xyz, face, uv, vec3(0.0));
            vec3 to = vec3(lamp.xyz - ray.cell) - ray.frac + 0.5 + 0.501 * ln + (rx_random(seed) - 0.5) * vec3(t) + (rx_random(seed) - 0.5) * vec3(b);
            float d2 = dot(to, to);
            dir = to * inversesqrt(d2);
            float cosine = -dot(dir, ln);
            if (cosine <= 0.0) continue;
            RxMaterial lm = rx_material_properties(hit_material(lamp.w));
            power = lm.albedo * lm.emission * cosine * float(lamp_count) / max(d2, 1.0);
            ray.dir = dir;
            ray.t_max = sqrt(d2);
        }
        RxHit unused;
        vec3 f = min(pbr(m.albedo, max(m.roughness, 0.15), m.metallic, n, v, dir), 4.0);
        if (f != vec3(0.0) && !rx_trace(ray, unused)) light[path.pixel].rgb += path.share * f * power;
    }
    // One of two ways on.
    float a = max(m.roughness * m.roughness, 0.002);
    vec3 f0 = mix(vec3(0.04), m.albedo, m.metallic);
    vec3 f = fresnel(f0, dot(n, v));
    float p = m.roughness >= 0.99 ? 0.0 : clamp(mix(max(f.x, max(f.y, f.z)), 1.0, m.metallic), 0.1, 1.0);
    vec3 dir, share;
    uint mirror = 0u;
    if (rx_random(seed) < p) {
        vec3 h = sample_vndf(v, n, a, seed);
        dir = reflect(-v, h);
        mirror = m.roughness < 0.15 ? 1u : 0u;
        float nl = dot(n, dir);
        if (nl <= 0.0) return;
        share = fresnel(f0, dot(v, h)) * smith_g1(nl, a) / p;
    } else {
        dir = cosine_direction(n, seed);
        share = m.albedo * (1.0 - m.metallic) * (1.0 - f) / (1.0 - p);
    }
    share *= path.share;
    if (push.bounce > 0) {
        float live = clamp(max(share.x, max(share.y, share.z)), 0.05, 1.0);
        if (rx_random(seed) > live) return;
        share /= live;
    }
    RxRay ray = rx_ray_from_face(hit.xyz, face, uv, dir);
    uint key = bin_of(ray.cell, dir);
    atomicAdd(next.bins[key], 1u);
    next_paths[atomicAdd(next.count, 1u)] = Path(ray.cell, path.pixel, ray.frac, seed, dir, key, share, mirror);
}
