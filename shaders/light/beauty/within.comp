// The view from within a clear body, such as water: the light that its matter takes away and scatters, what stands in it, and through its surface
// what stands outside. Beyond Snell's window the surface mirrors the body itself. One path a pixel and frame; the average takes the noise away.
// Above water the pass ends after one read.
#version 460
#include <raxel/world.glsl>
#include "../scene.glsl"
#include "beyond.glsl"
#include <raxel/random.glsl>
#include <raxel/light/bsdf.glsl>
#include <raxel/light/body.glsl>
#include <raxel/light/sampling.glsl>

layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba32i) uniform readonly iimage2D hits;
layout(rgba16f) uniform image2D gloss;

const uint FARTHEST = 160u, DEEPEST = 48u;   // voxels that a ray goes on in the body: the view, and the way up to daylight
const float ETA = 1.333, SCATTERED = 0.22;

// A ray that goes on in the cell behind a face, seen from the other side.
RxRay across(ivec3 cell, uint face, vec2 uv, vec3 dir) {
    RxRay ray = rx_ray_from_face(cell, face, uv, dir);
    uint axis = rx_face_axis(face);
    ray.cell = cell;
    ray.frac[axis] = 1.0 - ray.frac[axis];
    return ray;
}

// Direct sun and sky that come to a place in the air, the sky as one random ray; both for a surface that sends all of it on.
vec3 daylight(RxRay from, vec3 normal, vec3 to_sun, inout uint state) {
    RxHit hit;
    vec3 light = vec3(0.0);
    float cosine = dot(normal, to_sun);
    RxRay ray = from;
    ray.dir = to_sun;
    if (cosine > 0.0 && !rx_trace(ray, hit)) light += sun_irradiance(to_sun) * (sun_through_clouds(vec3(from.cell) + from.frac) * cosine / RX_PI);
    vec3 dir = normalize(normal + 0.999 * rx_random_direction(state));
    ray.dir = dir;
    if (!rx_trace(ray, hit)) light += sky_radiance(dir, to_sun);
    else if (hit.face != RX_FACE_INSIDE) light += rx_material_properties(hit.material).albedo * frame.lamp_strength * rx_material_properties(hit.material).emission;
    return light;
}

// Daylight at a point in the body: straight up to the surface, and from there to the sun and the sky.
vec3 light_within(ivec3 cell, vec3 frac, uint body, vec3 loss, vec3 to_sun, inout uint state) {
    vec3 up = vec3(0.0, 1.0, 0.0);
    RxBodyEnd end;
    if (!rx_walk_body(cell, frac, up, body, DEEPEST, end) || end.material != 0u) return vec3(0.0);
    return exp(-loss * end.t) * daylight(rx_ray_from_face(end.inside, end.face ^ 1u, end.uv, up), up, to_sun, state);
}

// Light that a surface in the air sends towards the ray.
vec3 shown(RxHit hit, vec3 to_sun, inout uint state) {
    RxMaterial material = rx_material_properties(hit.material);
    vec3 normal = rx_normal(hit.face);
    return material.albedo * (frame.lamp_strength * material.emission + daylight(rx_ray_from_face(hit.voxel, hit.face, hit.uv, normal), normal, to_sun, state));
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), size = imageSize(gloss);
    if (any(greaterThanEqual(pixel, size))) return;
    // All pixels begin in the same cell: one texel tells for all of them.
    ivec4 seen = imageLoad(hits, ivec2(0));
    if (seen.w < 0 || hit_face(seen.w) != RX_FACE_INSIDE) return;
    uint body = hit_material(seen.w);
    RxMaterial material = rx_material_properties(body);
    if (material.transparency <= 0.0) return;
    vec3 to_sun = frame_sun(), loss = rx_body_loss(material), dir = pixel_direction(pixel, size);
    uint state = rx_hash(scene_seed(uint(pixel.x) + rx_hash(uint(pixel.y) + 1201u)) ^ rx_hash(frame.index));
    ivec3 cell = frame.camera_cell;
    vec3 frac = frame.camera_frac, share = vec3(1.0), light = vec3(0.0);
    for (int turn = 0; turn < 3; ++turn) {
        RxBodyEnd end;
        bool ended = rx_walk_body(cell, frac, dir, body, FARTHEST, end);
        float far = ended ? end.t : 80.0;
        // What the body scatters on the way, lit as one of its places is: the nearer, the more often.
        vec3 through = exp(-loss * far);
        float mean_loss = dot(loss, vec3(1.0 / 3.0));
        float t = -log(1.0 - rx_random(state) * (1.0 - exp(-mean_loss * far))) / mean_loss;
        vec3 at = frac + t * dir;
        ivec3 step = ivec3(floor(at));
        if (rx_material(cell + step) == body)
            light += share * material.albedo * SCATTERED * (1.0 - through) * light_within(cell + step, at - vec3(step), body, loss, to_sun, state);
        if (!ended) break;
        share *= through;
        if (end.material != 0u) {
            // A wall or a ground in the body.
            RxMaterial ground = rx_material_properties(end.material);
            RxRay back = rx_ray_from_face(end.beyond, end.face, end.uv, -dir);
            light += share * ground.albedo * (frame.lamp_strength * ground.emission + light_within(back.cell, back.frac, body, loss, to_sun, state));
            break;
        }
        // The surface: refracted into the air, or mirrored.
        vec3 normal = rx_normal(end.face);
        vec3 outward = refract(dir, normal, ETA);
        float mirrored = outward == vec3(0.0) ? 1.0 : rx_fresnel_dielectric(clamp(-dot(outward, normal), 0.02, 1.0), ETA);
        if (rx_random(state) >= mirrored) {
            RxRay ray = across(end.beyond, end.face, end.uv, outward);
            RxHit hit;
            if (!rx_trace(ray, hit)) light += share * beyond(vec3(ray.cell - frame.camera_cell) + ray.frac, outward, to_sun);
            else if (hit.face != RX_FACE_INSIDE) light += share * shown(hit, to_sun, state);
            break;
        }
        RxRay back = rx_ray_from_face(end.beyond, end.face, end.uv, reflect(dir, normal));
        dir = back.dir;
        cell = back.cell;
        frac = back.frac;
    }
    imageStore(gloss, pixel, vec4(light, 0.0));
}
