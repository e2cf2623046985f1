// The rays of all probes: 32 directions even over the sphere, turned at random in each frame. At a ray's end, the sun, a lamp and the probes of
// the frame before give the light that comes back. So each frame adds a bounce.
#version 460
#include <raxel/world.glsl>
#include <raxel/thread.glsl>
#include "light/scene.glsl"
#include <raxel/light/lamps.glsl>
#include "probes.glsl"

layout(local_size_x = 32) in;
layout(std430) writeonly buffer Rays { vec4 rays[]; };

void main() {
    uint thread = rx_thread();
    ivec3 n = probe_counts();
    if (thread >= uint(n.x * n.y * n.z * PROBE_RAYS)) return;
    int probe = int(thread) / PROBE_RAYS;
    vec3 sun = frame_sun();
    RxSampler numbers = rx_sampler(frame.index, scene_seed(thread));
    vec3 dir = ray_direction(int(thread) % PROBE_RAYS, frame.index), light = vec3(0.0);
    RxRay ray = rx_ray(grid.world_min + PROBE_SPACING * probe_of(probe) + PROBE_SPACING / 2, vec3(0.0), dir);
    RxHit seen;
    float distance = RX_FAR;
    vec3 albedo = vec3(0.0), waiting = vec3(0.0);
    for (int turn = 0; turn < 3; ++turn) {
        RxHit hit;
        bool found = rx_trace(ray, hit);
        if (turn == 0) {
            if (!found) {
                light = sky_radiance(dir, sun);
                break;
            }
            distance = hit.face == RX_FACE_INSIDE ? 0.0 : hit.t;
            if (hit.face == RX_FACE_INSIDE) break;
            seen = hit;
            albedo = rx_material_properties(hit.material).albedo;
            RxRay from = rx_ray_from_face(seen.voxel, seen.face, seen.uv, rx_normal(seen.face));
            light = albedo * probe_light(from.cell, from.frac, seen.face);
            vec3 to = rx_sun_point(sun, rx_next2(numbers));
            waiting = albedo * sun_irradiance(sun) * (max(dot(rx_normal(seen.face), to), 0.0) / RX_PI);
            ray = rx_ray_from_face(seen.voxel, seen.face, seen.uv, to);
            if (waiting != vec3(0.0)) continue;
            turn = 1;
            found = true;
        }
        if (!found) light += waiting;
        if (turn == 2) break;
        RxRay from = rx_ray_from_face(seen.voxel, seen.face, seen.uv, rx_normal(seen.face));
        RxLampSample lamp = rx_resample_lamps(4u, numbers, from, rx_normal(seen.face), 0.0);
        waiting = albedo * frame.lamp_strength * lamp.light;
        if (waiting == vec3(0.0)) break;
        ray = rx_lamp_ray(from, lamp.to);
    }
    rays[thread] = vec4(light, distance);
}
