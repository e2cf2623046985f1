// Draws the view from within a clear body, for example water. The body absorbs and scatters light. The view shows the things in it and, through
// its surface, those outside. Beyond Snell's window the surface mirrors the body itself. One path a pixel and frame; the average takes the
// noise away. Above water the pass ends after one read.
#version 460
#include <raxel/scene.glsl>
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

// Direct sun and sky at a place in the air, for a surface that reflects all light. One random ray finds the sky. The rays take turns, because each
// call of the tracer is compiled into the shader.
vec3 daylight(RxSceneRay from, vec3 normal, vec3 to_sun, inout uint state) {
    vec3 light = vec3(0.0);
    float cosine = dot(normal, to_sun);
    for (int i = 0; i < 2; ++i) {
        bool sun = i == 0;
        if (sun && cosine <= 0.0) continue;
        RxSceneRay ray = from;
        RX_RAY(ray).dir = to_sun;
        if (!sun) RX_RAY(ray).dir = normalize(normal + 0.999 * rx_random_direction(state));
        RxHit hit;
        if (!rx_trace_places(ray, hit)) {
            if (sun) light += sun_irradiance(to_sun) * (sun_through_clouds(vec3(RX_RAY(from).cell) + RX_RAY(from).frac) * cosine / RX_PI);
            else light += sky_radiance(RX_RAY(ray).dir, to_sun);
        } else if (!sun && hit.face != RX_FACE_INSIDE) {
            RxMaterial material = rx_material_properties(hit.material);
            light += material.albedo * frame.lamp_strength * material.emission;
        }
    }
    return light;
}

// Daylight at a point in the body: straight up to the surface, and from there to the sun and the sky.
vec3 light_within(RxSceneRay from, uint body, vec3 loss, vec3 to_sun, inout uint state) {
    vec3 up = vec3(0.0, 1.0, 0.0);
    RxBodyEnd end;
    RxHit above;
    RX_RAY(from).dir = up;
    if (!rx_walk_body(RX_RAY(from).cell, RX_RAY(from).frac, up, body, DEEPEST, end) || end.material != 0u || rx_instance_in_body(from, end.t, above)) return vec3(0.0);
    return exp(-loss * end.t) * daylight(rx_scene_ray(rx_ray_from_face(end.inside, end.face ^ 1u, end.uv, up)), up, to_sun, state);
}

// Light that a surface in the air sends towards the ray.
vec3 shown(RxHit hit, vec3 to_sun, inout uint state) {
    RxMaterial material = rx_material_properties(hit.material);
    vec3 normal = rx_place_normal(hit.voxel, hit.face);
    return material.albedo * (frame.lamp_strength * material.emission + daylight(rx_ray_from_place(hit.voxel, hit.face, hit.uv, normal), normal, to_sun, state));
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), size = imageSize(gloss);
    if (any(greaterThanEqual(pixel, size))) return;
    // All pixels begin in the same cell: one texel answers for all of them.
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
        // An instance that stands in the body is nearer than its end.
        RxHit standing;
        bool stands = rx_instance_in_body(rx_scene_ray(RxRay(cell, frac, dir, far)), far, standing);
        if (stands) far = standing.t;
        // The light that the body scatters on the way, lit as one of its places is: the nearer, the more often.
        vec3 through = exp(-loss * far);
        float mean_loss = dot(loss, vec3(1.0 / 3.0));
        float t = -log(1.0 - rx_random(state) * (1.0 - exp(-mean_loss * far))) / mean_loss;
        vec3 at = frac + t * dir;
        ivec3 step = ivec3(floor(at));
        if (rx_material(cell + step) == body)
            light += share * material.albedo * SCATTERED * (1.0 - through) * light_within(rx_scene_ray(rx_ray(cell + step, at - vec3(step), dir)), body, loss, to_sun, state);
        if (!ended && !stands) break;
        share *= through;
        if (stands || end.material != 0u) {
            // An instance, or a wall or a ground in the body.
            RxMaterial matter = rx_material_properties(stands ? standing.material : end.material);
            RxSceneRay back = rx_scene_ray(rx_ray_from_face(end.beyond, end.face, end.uv, -dir));
            if (stands) back = rx_ray_from_place(standing.voxel, standing.face, standing.uv, -dir);
            light += share * matter.albedo * (frame.lamp_strength * matter.emission + light_within(back, body, loss, to_sun, state));
            break;
        }
        // The surface: refracted into the air, or mirrored.
        vec3 normal = rx_normal(end.face);
        vec3 outward = refract(dir, normal, ETA);
        float mirrored = outward == vec3(0.0) ? 1.0 : rx_fresnel_dielectric(clamp(-dot(outward, normal), 0.02, 1.0), ETA);
        if (rx_random(state) >= mirrored) {
            RxRay ray = across(end.beyond, end.face, end.uv, outward);
            RxHit hit;
            if (!rx_trace_places(rx_scene_ray(ray), hit)) light += share * beyond(vec3(ray.cell - frame.camera_cell) + ray.frac, outward, to_sun);
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
