// The light from the place that each path has reached, its requests there, and the way on. The paths that go on close up; which place each
// gets depends on the order of threads, its light does not.
#version 460
#include <raxel/world.glsl>
#include <raxel/thread.glsl>
#include "light/scene.glsl"
#include <raxel/light/lamps.glsl>
#include "wave.glsl"

layout(local_size_x = 64) in;
layout(std430) readonly buffer Queue { uint count; uint bins[WAVE_BINS]; } queue;
layout(std430) buffer Next { uint count; uint bins[WAVE_BINS]; } next;
layout(std430) readonly buffer Paths { Path paths[]; };
layout(std430) writeonly buffer NextPaths { Path next_paths[]; };
layout(std430) readonly buffer Hits { PathHit hits[]; };
layout(std430) buffer Light { vec4 light[]; };
layout(std430) buffer Asking { uint asking; };
layout(std430) writeonly buffer Asks { Ask asks[]; };
layout(std140) uniform Grid { ivec3 world_min; } grid;
layout(push_constant) uniform Push { uint bounce; } push;

void main() {
    uint i = rx_thread();
    if (i >= queue.count) return;
    Path path = paths[i];
    ivec4 hit = hits[i].at;
    vec4 place = hits[i].place;
    vec3 sun = frame_sun();
    if (hit.w < 0) {
        light[path.pixel].rgb += path.share * sky_radiance(path.dir, sun);
        return;
    }
    uint face = hit_face(hit.w);
    if (face == RX_FACE_INSIDE) return;
    RxMaterial material = rx_material_properties(hit_material(hit.w));
    vec3 normal = rx_normal(face);
    if (material.emission > 0.0) {
        vec3 radiance = material.albedo * material.emission;
        float weight = 1.0;
        if (push.bounce > 0u) {
            float picked = rx_light_probability(radiance) * place.z * place.z / max(-dot(normal, path.dir), 1e-6);
            weight = rx_power_weight(path.density, picked);
        }
        light[path.pixel].rgb += path.share * frame.lamp_strength * radiance * weight;
    }
    // Numbers by pixel, frame and step: pairs of their own for each.
    RxSampler numbers = rx_sampler(frame.still, scene_seed(path.pixel ^ rx_hash(push.bounce)));
    vec3 share = path.share * material.albedo;
    RxRay from = rx_ray_from_face(hit.xyz, face, place.xy, normal);
    vec3 to = rx_sun_point(sun, rx_next2(numbers));
    vec3 sunlight = share * sun_irradiance(sun) * (max(dot(normal, to), 0.0) / RX_PI);
    RxLampSample lamp = rx_resample_lamps(1u, numbers, from, normal, 1.0);
    vec3 lamplight = share * frame.lamp_strength * lamp.light;
    if (sunlight != vec3(0.0) || lamplight != vec3(0.0)) {
        asks[atomicAdd(asking, 1u)] = Ask(from.cell, path.pixel, from.frac, 0.0, to, 0.0, sunlight, 0.0, lamp.to, 0.0, lamplight, 0.0);
    }
    if (push.bounce >= 3u) {
        float on = min(max(share.x, max(share.y, share.z)), 0.95);
        if (rx_next(numbers) >= on) return;
        share /= on;
    }
    vec3 dir = rx_cosine_direction(face, rx_next2(numbers));
    uint bin = wave_bin(from.cell, grid.world_min, dir);
    atomicAdd(next.bins[bin], 1u);
    next_paths[atomicAdd(next.count, 1u)] = Path(from.cell, path.pixel, from.frac, dot(normal, dir) / RX_PI, dir, bin, share, 0u);
}
