// The world with the water as its voxels, by exact rays alone. Water mirrors by Fresnel's law, and shows the things behind it, less the loss by
// its colour on the way. Rays to the sun go through it.
#version 460
#include <raxel/world.glsl>
#include <raxel/shade.glsl>
#include <raxel/camera.glsl>
#include <raxel/light/bsdf.glsl>
#include <raxel/light/body.glsl>

layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba16f) uniform writeonly image2D outColor;
layout(push_constant) uniform Push {
    mat4 view_to_world;
    ivec3 camera_cell;
    float exposure;
    vec3 camera_frac;
    vec2 tan_half_fov;
} push;

const float ETA = 1.333;
const uint DEEPEST = 64u;   // voxels of water that are looked through

// The light that a place reflects, and the sunlight that it would reflect if nothing were in the way.
vec3 surface_light(RxHit hit, vec3 sun, out vec3 sunlight) {
    vec3 normal = rx_normal(hit.face);
    RxMaterial material = rx_material_properties(hit.material);
    vec3 albedo = material.albedo * rx_grain(hit.voxel);
    sunlight = albedo * 2.3 * max(dot(normal, sun), 0.0) * rx_sun_color(sun);
    return albedo * (material.emission + 0.6 * rx_openness(hit) * rx_ambient(normal, sun));
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), size = imageSize(outColor);
    if (any(greaterThanEqual(pixel, size))) return;
    vec3 sun = rx_sun_direction(215.0, 42.0);
    vec3 dir = rx_camera_direction(push.view_to_world, push.tan_half_fov, vec2(pixel) + 0.5, vec2(size));
    RxRay ray = rx_ray(push.camera_cell, push.camera_frac, dir);
    // One loop around one tracer. It traces the ray of the pixel; if that meets water, the mirrored ray; and from each place a ray to the sun. The
    // way on through the water is walked, and its end is the next place.
    const uint SEEN = 0u, MIRRORED = 1u, THROUGH = 2u;
    vec3 color = vec3(0.0), share = vec3(1.0), sunlight, beyond_share = vec3(0.0);
    RxHit beyond;
    RxRay out_of_water;
    bool sunward = false, below = false, leaves = false;
    uint way = SEEN;
    for (int turn = 0; turn < 12; ++turn) {
        RxHit hit;
        bool found;
        if (way == THROUGH && below && !sunward) {
            hit = beyond;
            found = true;
        } else {
            found = rx_trace(ray, hit);
        }
        if (sunward) {
            if (found && rx_pass_body(hit, DEEPEST, ray, sunlight)) continue;
            if (!found) color += share * sunlight;
        } else if (!found) {
            color += share * rx_sky(ray.dir, sun);
        } else if (hit.face != RX_FACE_INSIDE) {
            RxMaterial material = rx_material_properties(hit.material);
            vec3 normal = rx_normal(hit.face);
            if (way == SEEN && material.transparency > 0.0) {
                float mirrored = rx_fresnel_dielectric(clamp(-dot(ray.dir, normal), 0.02, 1.0), ETA);
                vec3 inward = refract(ray.dir, normal, 1.0 / ETA);
                RxRay from = rx_ray_from_face(hit.voxel, hit.face, hit.uv, inward);
                uint axis = rx_face_axis(hit.face);
                from.frac[axis] = 1.0 - from.frac[axis];
                RxBodyEnd end;
                bool ends = rx_walk_body(hit.voxel, from.frac, inward, hit.material, DEEPEST, end);
                beyond_share = ends ? (1.0 - mirrored) * exp(-rx_body_loss(material) * end.t) : vec3(0.0);
                below = ends && end.material != 0u;
                leaves = ends && end.material == 0u;
                beyond = RxHit(end.beyond, end.face, end.material, 0.0, end.uv, 0u);
                // Through the far side of the water, straight on as it came.
                out_of_water = rx_ray_from_face(end.inside, end.face ^ 1u, end.uv, ray.dir);
                // The light that the water itself scatters back.
                color += (1.0 - mirrored) * 0.06 * material.albedo * rx_ambient(normal, sun);
                ray = rx_ray_from_face(hit.voxel, hit.face, hit.uv, reflect(ray.dir, normal));
                share = vec3(mirrored);
                way = MIRRORED;
                continue;
            }
            color += share * surface_light(hit, sun, sunlight);
            if (sunlight.y > 0.0) {
                ray = rx_ray_from_face(hit.voxel, hit.face, hit.uv, sun);
                sunward = true;
                // Below the water, the ray to the sun begins in it.
                if (way == THROUGH && below) {
                    RxBodyEnd end;
                    uint water = rx_material(ray.cell);
                    if (!rx_walk_body(ray.cell, ray.frac, sun, water, DEEPEST, end) || end.material != 0u) break;
                    sunlight *= exp(-rx_body_loss(rx_material_properties(water)) * end.t);
                    ray = rx_ray_from_face(end.inside, end.face ^ 1u, end.uv, sun);
                }
                continue;
            }
        }
        if (way != MIRRORED || !(below || leaves)) break;
        way = THROUGH;
        share = beyond_share;
        ray = out_of_water;
        sunward = false;
    }
    imageStore(outColor, pixel, vec4(rx_tone_curve(push.exposure * color), 1.0));
}
