// Path tracing without a bias. Each vertex is lit by a point of the sun's disc and a point of a lamp, and the path goes on with a cosine
// ray that finds the sky and, weighted against the drawn points, lamps (Veach and Guibas, "Optimally combining sampling techniques", 1995).
// Surfaces are matt. Instances are lit, and give light, like everything else, but no lamp is drawn on them. One call
// in one loop traces all rays of all paths of a pixel. So the shader has the tracer once, and a thread with a short
// path begins the next one without waiting.
#version 460
#include <raxel/scene.glsl>
#include <raxel/light/lights.glsl>
#include <raxel/light/sobol.glsl>
#include "frame.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba32f) uniform image2D sum;      // of the paths' light; their number
layout(rgba32f) uniform image2D rest;     // the rounding errors of `sum`
layout(rgba32f) uniform image2D squares;  // of the paths' light
layout(rgba32f) uniform writeonly image2D outRadiance;
layout(push_constant) uniform Push {
    int paths;
    float filter_width;
} push;

const uint MOST_VERTICES = 256u;  // a path of a room with albedo 0.9 is that long once in 10^11
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

// The density by area of a lamp of this radiance. It is in proportion to the lamp's power. For comparison, a graph can make it the
// same for all faces, if these have the same size.
float lamp_density(vec3 radiance) {
#ifdef LAMPS_EVENLY
    return rx_lights_count() > 0u ? 1.0 / float(rx_lights_count()) : 0.0;
#else
    return rx_light_probability(radiance);
#endif
}

RxLight draw_lamp(uvec2 random) {
#ifdef LAMPS_EVENLY
    uint index, rest;
    umulExtended(random.x, rx_lights_count(), index, rest);
    RxLight lamp = rx_light(index);
    lamp.probability = lamp_density(vec3(0.0));
    return lamp;
#else
    return rx_light(rx_pick_light(random));
#endif
}

// Adds paths of a pixel to those of the frames before.
void add(ivec2 pixel, vec3 light, vec3 square) {
    vec4 before = vec4(0.0), lost = vec4(0.0), squared = vec4(0.0);
    if (frame.still > 0u) {
        before = imageLoad(sum, pixel);
        lost = imageLoad(rest, pixel);
        squared = imageLoad(squares, pixel);
    }
    vec4 added = vec4(light, float(push.paths));
    // Two floats hold the sum: the second one has the rounding errors of the first (Knuth's TwoSum).
    precise vec4 now = before + added;
    precise vec4 part = now - before;
    precise vec4 error = (before - (now - part)) + (added - part);
    lost += error;
    imageStore(sum, pixel, now);
    imageStore(rest, pixel, lost);
    imageStore(squares, pixel, squared + vec4(square, 0.0));
    vec3 mean = (now.rgb + lost.rgb) / now.a;
    imageStore(outRadiance, pixel, vec4(mean, 1.0));
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), size = imageSize(outRadiance);
    if (any(greaterThanEqual(pixel, size))) return;
    vec3 sun = frame_sun(), sun_light = rx_sun_light(sun, frame.sun_strength);
    uint seed = rx_hash(uint(pixel.y * size.x + pixel.x) ^ rx_hash(frame.seed));
    uint index = frame.still > 0u ? uint(imageLoad(sum, pixel).a) : 0u, end = index + uint(push.paths);
    vec3 all = vec3(0.0), squared = vec3(0.0);  // of the paths that are done

    // Of a path: its light, and how much of the light at its last vertex comes back to the camera. All rays of a vertex start at one place.
    vec3 light = vec3(0.0), share = vec3(0.0), pending = vec3(0.0);
    uint kind = PATH, vertex = 0u, face = RX_FACE_INSIDE;
    float density = 0.0;  // of the direction of the path's last ray
    RxLight lamp;
    RxSceneRay ray;
    ivec3 voxel = ivec3(0);  // of the path's last vertex
    bool begins = true;
    while (index < end) {
        if (begins) {
            begins = false;
            vec2 place = vec2(pixel) + 0.5 + push.filter_width * (rx_sobol(index, 0u, seed) - 0.5);
            vec3 dir = rx_camera_direction(frame.view_to_world, frame.tan_half_fov, place, vec2(size));
            ray = rx_scene_ray(rx_ray(frame.camera_cell, frame.camera_frac, dir));
            kind = PATH;
            vertex = 0u;
            light = vec3(0.0);
            share = vec3(1.0);
        }

        RxHit target;
        bool found = rx_trace_places(ray, target);
        if (kind != PATH) {
            bool reached = kind == SUN ? !found : found && rx_is_on_light(lamp, target.voxel, target.face);
            if (reached) light += pending;
        } else if (!found) {
            light += share * rx_sky_light(RX_RAY(ray).dir, sun, frame.sky_strength);
            begins = true;
        } else {
            RxMaterial material = rx_material_properties(target.material);
            vec3 own = emitted(material);
            if (vertex > 0u && own != vec3(0.0) && !rx_is_on_instance(target.face)) {
                // The lamp could have been drawn as a point, with this density over the solid angle.
                float facing = abs(dot(RX_RAY(ray).dir, rx_normal(target.face)));
                own *= weight(density, lamp_density(material.emission * material.albedo) * target.t * target.t / max(facing, 1e-20));
            }
            light += share * own;
            share *= material.albedo;
            float most = max(share.r, max(share.g, share.b));
            begins = target.face == RX_FACE_INSIDE || ++vertex >= MOST_VERTICES || most <= 0.0;
            if (!begins && vertex >= 4u) {
                float live = min(0.95, most);
                begins = rx_sobol(index, PAIRS * vertex + 4u, seed).x >= live;
                share /= live;
            }
            face = target.face;
            voxel = target.voxel;
            ray = rx_ray_from_place(voxel, face, target.uv, RX_RAY(ray).dir);
        }
        if (begins) {
            all += light;
            squared += light * light;
            ++index;
            continue;
        }

        // The next ray: to the sun, to a lamp, and on.
        vec3 normal = rx_place_normal(voxel, face);
        if (kind == PATH) {
            kind = SUN;
            RX_RAY(ray).dir = rx_sun_point(sun, rx_sobol(index, PAIRS * vertex, seed));
            pending = share * sun_light * (max(dot(normal, RX_RAY(ray).dir), 0.0) / RX_PI);
            if (pending != vec3(0.0)) continue;
        }
        if (kind == SUN) {
            kind = LAMP;
            if (rx_lights_count() > 0u) {
                lamp = draw_lamp(rx_sobol_bits(index, PAIRS * vertex + 1u, seed));
                vec3 to = rx_to_light(lamp, rx_sobol(index, PAIRS * vertex + 2u, seed), RX_RAY(ray).cell, RX_RAY(ray).frac);
                float square = dot(to, to);
                vec3 dir = to * inversesqrt(max(square, 1e-20));
                float cosine = dot(normal, dir), facing = -dot(rx_normal(lamp.face), dir);
                if (cosine > 0.0 && facing > 0.0) {
                    float drawn = lamp.probability * square / facing;
                    pending = share * emitted(rx_material_properties(lamp.material)) *
                              (cosine / (RX_PI * drawn) * weight(drawn, cosine / RX_PI));
                    RX_RAY(ray).dir = dir;
                    if (pending != vec3(0.0)) continue;
                }
            }
        }
        kind = PATH;
        RX_RAY(ray).dir = rx_place_vector(voxel, face, rx_cosine_direction(RX_FACE_PART(face), rx_sobol(index, PAIRS * vertex + 3u, seed)));
        density = max(dot(normal, RX_RAY(ray).dir), 1e-20) / RX_PI;
    }
    add(pixel, all, squared);
}
