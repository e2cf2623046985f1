// 4: one invocation a face: a sun ray and a sky ray, averaged over time where the face is and not where the camera was.
#version 460
#include <raxel/world.glsl>
#include <raxel/shade.glsl>
#include <raxel/thread.glsl>
#include "surface.glsl"
layout(local_size_x = 64) in;
layout(std430) readonly buffer Pool { int free_count; uint next; uint list_count; uint tick; uint free[]; } pool;
layout(std430) readonly buffer List { uint list[]; };
layout(std430) buffer Faces { Face faces[]; };
layout(r32ui) uniform readonly uimage3D slots;
layout(std430) readonly buffer Lamps { uint count; uint pad[3]; ivec4 at[]; } lamps;
layout(push_constant) uniform Push { float keep; int rays; } push;

void main() {
    uint i = rx_thread();
    if (i >= min(pool.list_count, LIST)) return;
    uint id = list[i];
    ivec3 voxel = unpack_voxel(faces[id].voxel);
    uint face = faces[id].face;
    vec3 normal = rx_normal(face), sun = rx_sun_direction(frame.sun_azimuth, frame.sun_elevation);
    uint seed = rx_hash(faces[id].voxel * 8u + face + rx_hash(frame.index));
    vec3 light = vec3(0.0);
    RxHit hit;
    uint n_lamps = min(lamps.count, 4096u);
    // Rays take turns in one loop, so that the tracer is compiled once: the sun, a lamp, any direction.
    for (int turn = 0; turn < 3 * push.rays; ++turn) {
        int kind = turn % 3;
        RxRay ray = rx_ray_from_face(voxel, face, vec2(rx_random(seed), rx_random(seed)), normal);
        vec3 power = vec3(0.0);
        if (kind == 0) {
            ray.dir = around(sun, 0.03, seed);
            power = 2.3 * max(dot(normal, ray.dir), 0.0) * rx_sun_color(sun);
        } else if (kind == 1 && n_lamps > 0u) {
            ivec4 lamp = lamps.at[rx_random_uint(seed) % n_lamps];
            vec3 ln = rx_normal(hit_face(lamp.w));
            ivec3 t, b;
            rx_face_tangents(hit_face(lamp.w), t, b);
            vec3 to = vec3(lamp.xyz - ray.cell) - ray.frac + 0.5 + 0.501 * ln + (rx_random(seed) - 0.5) * vec3(t) + (rx_random(seed) - 0.5) * vec3(b);
            float d2 = dot(to, to);
            ray.dir = to * inversesqrt(d2);
            ray.t_max = sqrt(d2);
            RxMaterial lm = rx_material_properties(hit_material(lamp.w));
            power = lm.albedo * lm.emission * max(-dot(ray.dir, ln), 0.0) * max(dot(normal, ray.dir), 0.0) * float(n_lamps) / (PI * max(d2, 2.0));
        } else if (kind == 2) ray.dir = cosine_direction(normal, seed);
        if (kind != 2 && power == vec3(0.0)) continue;
        bool found = rx_trace(ray, hit);
        if (kind != 2) { if (!found) light += power; }
        else if (!found) light += 0.9 * rx_sky(ray.dir, sun);
        else if (hit.face != RX_FACE_INSIDE) {
            // What the face that was hit had at the beginning of the tick: every tick is a bounce more.
            RxMaterial m = rx_material_properties(hit.material);
            uint slot = imageLoad(slots, hit.voxel - frame.world_min).x;
            vec3 theirs = slot != 0u && slot <= SLOTS ? faces[6u * (slot - 1u) + hit.face].before.rgb : vec3(0.0);
            light += m.albedo * (theirs == vec3(0.0) ? vec3(0.1) : theirs);
        }
    }
    light /= float(push.rays);
    vec4 old = faces[id].light;
    float n = min(old.w + 1.0, push.keep);
    faces[id].light = vec4(mix(old.rgb, light, 1.0 / n), n);
}
