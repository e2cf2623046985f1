// Light that falls on a place of a face, by one path: from the sky, from lamps, and all that other faces send back. Needs
// <raxel/world.glsl> and scene.glsl. Before the include,
//
//     #define PATH_CANDIDATES n     lamps compared at the first place, 1 at the others
//     #define PATH_SUN_FIRST        also counts direct sun at the first place, which is left out otherwise
//     #define PATH_KEPT             a function `vec4 kept(RxHit hit)` knows what falls on a face without direct sun, / pi; w is 0 where not
#ifndef LIGHT_PATH_GLSL
#define LIGHT_PATH_GLSL

#include <raxel/light/lamps.glsl>

const uint PATH_ROULETTE_FROM = 3u;

// Irradiance / pi: what a white matt surface would send back.
vec3 path_light(ivec3 voxel, uint face, vec2 uv, inout RxSampler numbers) {
    vec3 sun = frame_sun(), sun_light = sun_irradiance(sun);
    RxHit at = RxHit(voxel, face, 0u, 0.0, uv, 0u);
    // Rays take turns, because each call of the tracer is compiled into the shader: at each place a ray to a lamp, one to the sun, and
    // one that goes on.
    const uint LAMP = 0u, SUN = 1u, ON = 2u;
    uint kind = ON, depth = 0u;
    vec3 sum = vec3(0.0), share = vec3(1.0), waiting = vec3(0.0);
    bool ends = false;    // the rest of the light is known
    bool arrived = true;  // at a place whose light is asked for
    RxRay ray;
    for (uint turn = 0u; turn < 256u; ++turn) {
        if (!arrived) {
            RxHit hit;
            bool found = rx_trace(ray, hit);
            if (kind != ON) {
                if (!found) sum += share * waiting;
            } else {
                if (!found) {
                    sum += share * sky_radiance(ray.dir, sun);
                    break;
                }
                if (hit.face == RX_FACE_INSIDE) break;
                RxMaterial material = rx_material_properties(hit.material);
                // A lamp that is met by chance counts where picking lamps would do worse: close to it. At the first place it does not,
                // as the density of what is picked from several is not known.
                if (depth > 0u && material.emission > 0.0) {
                    vec3 radiance = material.albedo * material.emission;
                    float facing = max(dot(rx_normal(at.face), ray.dir), 0.0) / RX_PI;
                    float picked = rx_light_probability(radiance) * hit.t * hit.t / max(-dot(rx_normal(hit.face), ray.dir), 1e-6);
                    sum += share * frame.lamp_strength * radiance * rx_power_weight(facing, picked);
                }
                at = hit;
                share *= material.albedo;
                ++depth;
                arrived = true;
#ifdef PATH_KEPT
                vec4 known = kept(hit);
                if (known.w > 0.0) {
                    sum += share * known.rgb;
                    ends = true;
                }
#endif
            }
        }
        vec3 normal = rx_normal(at.face);
        if (arrived) {
            arrived = false;
            kind = LAMP;
            if (!ends) {
                RxRay from = rx_ray_from_face(at.voxel, at.face, at.uv, normal);
                RxLampSample lamp = rx_resample_lamps(depth == 0u ? uint(PATH_CANDIDATES) : 1u, numbers, from, normal);
                waiting = frame.lamp_strength * lamp.light;
                if (depth > 0u && waiting != vec3(0.0)) waiting *= rx_power_weight(lamp.density, dot(normal, normalize(lamp.to)) / RX_PI);
                ray = rx_lamp_ray(from, lamp.to);
                if (waiting != vec3(0.0)) continue;
            }
        }
        if (kind == LAMP) {
            kind = SUN;
#ifdef PATH_SUN_FIRST
            vec3 to = rx_sun_point(sun, rx_next2(numbers));
#else
            vec3 to = depth > 0u ? rx_sun_point(sun, rx_next2(numbers)) : vec3(0.0);
#endif
            waiting = sun_light * (max(dot(normal, to), 0.0) / RX_PI);
            ray = rx_ray_from_face(at.voxel, at.face, at.uv, to);
            if (waiting != vec3(0.0)) continue;
        }
        if (ends) break;
        kind = ON;
        if (depth >= PATH_ROULETTE_FROM) {
            float on = min(max(share.x, max(share.y, share.z)), 0.95);
            if (rx_next(numbers) >= on) break;
            share /= on;
        }
        ray = rx_ray_from_face(at.voxel, at.face, at.uv, rx_cosine_direction(at.face, rx_next2(numbers)));
    }
    return sum;
}

#endif
