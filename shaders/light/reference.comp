// Path tracing without a bias. Each vertex is lit by a point of the sun's disc and a point of a lamp, and the path goes on with a cosine
// ray that finds the sky and, weighted against the drawn points, lamps (Veach and Guibas, "Optimally combining sampling techniques", 1995).
// Surfaces are matt. A ray of each kind is traced at the same place in the loop, so that the tracer is there once.
#version 460
#include <raxel/world.glsl>
#include <raxel/shade.glsl>
#include <raxel/light/lights.glsl>
#include <raxel/light/sobol.glsl>
#include "frame.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba32f) uniform image2D sum;      // of the paths' light; their number
layout(rgba32f) uniform image2D rest;     // what `sum` has lost to rounding
layout(rgba32f) uniform image2D squares;  // of the paths' light
layout(rgba32f) uniform writeonly image2D outRadiance;
layout(rgba16f) uniform writeonly image2D outColor;
layout(push_constant) uniform Push {
    int paths;
    float filter_width;
    float exposure;
} push;

const uint MOST_VERTICES = 256u;  // a path of a room with albedo 0.9 gets so far once in 10^11
const uint PAIRS = 5u;            // of random numbers, a vertex

const uint PATH = 0u, SUN = 1u, LAMP = 2u;

vec3 emitted(RxMaterial material) {
    return frame.lamp_strength * material.emission * material.albedo;
}

// The power heuristic: the weight of a sample whose density is `a` where the other technique has the density `b`.
float weight(float a, float b) {
    float ratio = b / a;
    return 1.0 / (1.0 + ratio * ratio);
}

// Radiance along a ray.
vec3 path_light(RxRay ray, uint index, uint seed) {
    vec3 sun = frame_sun(), sun_light = rx_sun_light(sun, frame.sun_strength);
    vec3 light = vec3(0.0), share = vec3(1.0), pending = vec3(0.0);
    uint kind = PATH, vertex = 0u;
    float density = 0.0;  // of the direction of the path's last ray
    RxHit at, target;
    RxLight lamp;
    while (true) {
        bool found = rx_trace(ray, target);
        if (kind == PATH) {
            if (!found) {
                light += share * rx_sky_light(ray.dir, sun, frame.sky_strength);
                break;
            }
            at = target;
            RxMaterial material = rx_material_properties(at.material);
            vec3 own = emitted(material);
            if (vertex > 0u && own != vec3(0.0)) {
                // The lamp could have been drawn as a point, with this density over the solid angle.
                float facing = abs(dot(ray.dir, rx_normal(at.face)));
                own *= weight(density, rx_light_probability(material.emission * material.albedo) * at.t * at.t / max(facing, 1e-20));
            }
            light += share * own;
            share *= material.albedo;
            float most = max(share.r, max(share.g, share.b));
            if (at.face == RX_FACE_INSIDE || ++vertex >= MOST_VERTICES || most <= 0.0) break;
            if (vertex >= 4u) {
                float live = min(0.95, most);
                if (rx_sobol(index, PAIRS * vertex + 4u, seed).x >= live) break;
                share /= live;
            }
        } else {
            bool reached = kind == SUN ? !found : found && rx_is_on_light(lamp, target.voxel, target.face);
            if (reached) light += pending;
        }

        // The next ray: to the sun, to a lamp, and on.
        vec3 normal = rx_normal(at.face);
        if (kind == PATH) {
            kind = SUN;
            vec3 dir = rx_sun_point(sun, rx_sobol(index, PAIRS * vertex, seed));
            pending = share * sun_light * (max(dot(normal, dir), 0.0) / RX_PI);
            ray = rx_ray_from_face(at.voxel, at.face, at.uv, dir);
            if (pending != vec3(0.0)) continue;
        }
        if (kind == SUN) {
            kind = LAMP;
            if (rx_lights_count() > 0u) {
                lamp = rx_light(rx_pick_light(rx_sobol_bits(index, PAIRS * vertex + 1u, seed)));
                ray = rx_ray_from_face(at.voxel, at.face, at.uv, normal);
                vec3 to = rx_to_light(lamp, rx_sobol(index, PAIRS * vertex + 2u, seed), ray.cell, ray.frac);
                float square = dot(to, to);
                vec3 dir = to * inversesqrt(max(square, 1e-20));
                float cosine = dot(normal, dir), facing = -dot(rx_normal(lamp.face), dir);
                if (cosine > 0.0 && facing > 0.0) {
                    float drawn = lamp.probability * square / facing;
                    pending = share * emitted(rx_material_properties(lamp.material)) *
                              (cosine / (RX_PI * drawn) * weight(drawn, cosine / RX_PI));
                    ray.dir = dir;
                    if (pending != vec3(0.0)) continue;
                }
            }
        }
        kind = PATH;
        vec3 dir = rx_cosine_direction(at.face, rx_sobol(index, PAIRS * vertex + 3u, seed));
        density = max(dot(normal, dir), 1e-20) / RX_PI;
        ray = rx_ray_from_face(at.voxel, at.face, at.uv, dir);
    }
    return light;
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    ivec2 size = imageSize(outRadiance);
    if (any(greaterThanEqual(pixel, size))) return;

    vec4 before = vec4(0.0), lost = vec4(0.0), square = vec4(0.0);
    if (frame.still > 0u) {
        before = imageLoad(sum, pixel);
        lost = imageLoad(rest, pixel);
        square = imageLoad(squares, pixel);
    }
    uint seed = rx_hash(uint(pixel.y * size.x + pixel.x) ^ rx_hash(frame.seed));
    vec4 added = vec4(0.0);
    for (int i = 0; i < push.paths; ++i) {
        uint index = uint(before.a) + uint(i);
        vec2 place = vec2(pixel) + 0.5 + push.filter_width * (rx_sobol(index, 0u, seed) - 0.5);
        vec3 dir = rx_camera_direction(frame.view_to_world, frame.tan_half_fov, place, vec2(size));
        vec3 light = path_light(rx_ray(frame.camera_cell, frame.camera_frac, dir), index, seed);
        added += vec4(light, 1.0);
        square.rgb += light * light;
    }
    // Two floats hold the sum: the second one has the rounding errors of the first (Knuth's TwoSum).
    precise vec4 now = before + added;
    precise vec4 part = now - before;
    precise vec4 error = (before - (now - part)) + (added - part);
    lost += error;
    imageStore(sum, pixel, now);
    imageStore(rest, pixel, lost);
    imageStore(squares, pixel, square);
    vec3 mean = (now.rgb + lost.rgb) / now.a;
    imageStore(outRadiance, pixel, vec4(mean, 1.0));
    imageStore(outColor, pixel, vec4(rx_tone_curve(push.exposure * mean), 1.0));
}
