// A path tracer for materials. At each surface one of its ways to send light on is drawn: a mirror image in a coat or a metal (GGX), light from
// inside (matt), or, in what is clear, a mirror image or the way through it by Fresnel's law. Inside a body the way goes from boundary
// to boundary; light is taken away by its colour. Instances are seen everywhere, also in bodies; what is clear of them is matt here, and no lamp is drawn on them.
#version 460
#include <raxel/scene.glsl>
#include "../scene.glsl"
#include <raxel/light/lamps.glsl>
#include <raxel/light/bsdf.glsl>
#include <raxel/light/body.glsl>

layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba32f) uniform image2D sum;
layout(rgba32f) uniform writeonly image2D outRadiance;
layout(push_constant) uniform Push { float index; int frames; } push;

const uint DEEPEST = 512u;   // voxels of a body on one way

vec3 to_frame(vec3 d, vec3 t, vec3 b, vec3 n) {
    return vec3(dot(d, t), dot(d, b), dot(d, n));
}

// Sunlight on a place under a level surface of the body: the beam is refracted there, and comes straight to it. Zero if a side, a wall or an instance is
// in the way; `out_ray` is the ray that must reach the sun then.
vec3 sun_below(RxSceneRay from, vec3 normal, vec3 sun, uint body, vec3 loss, out RxRay out_ray) {
    vec3 up = vec3(0.0, 1.0, 0.0), inward = refract(-sun, up, 1.0 / push.index);
    ivec3 cell = RX_RAY(from).cell;
    vec3 frac = RX_RAY(from).frac;
    out_ray = rx_ray(cell, frac, sun);
    RX_RAY(from).dir = -inward;
    float falls = dot(normal, -inward);
    if (sun.y <= 0.0 || falls <= 0.0) return vec3(0.0);
    RxBodyEnd end;
    if (!rx_walk_body(cell, frac, -inward, body, DEEPEST, end) || end.material != 0u || end.face != RX_FACE_NEG_Y) return vec3(0.0);
    RxHit above;
    if (rx_instance_in_body(from, end.t, above)) return vec3(0.0);
    out_ray = rx_ray(end.beyond, vec3(end.uv.x, 0.0, end.uv.y), sun);
    float through = (1.0 - rx_fresnel_dielectric(sun.y, push.index)) * sun.y / -inward.y;
    return sun_irradiance(sun) * exp(-loss * end.t) * (through * falls / RX_PI);
}

vec3 path(ivec2 pixel, ivec2 size) {
    RxSampler numbers = rx_sampler(frame.still, scene_seed(uint(pixel.x) + rx_hash(uint(pixel.y))));
    vec3 sun = frame_sun();
    vec3 dir = rx_camera_direction(frame.view_to_world, frame.tan_half_fov, vec2(pixel) + rx_next2(numbers), vec2(size));
    vec3 light = vec3(0.0), share = vec3(1.0), waiting = vec3(0.0), shadow_share = vec3(0.0);
    RxSceneRay ray = rx_scene_ray(rx_ray(frame.camera_cell, frame.camera_frac, dir)), later;
    // Whether the ray of this turn asks for light; is in a body, or goes on in one afterwards (below); counts the lamps that it meets.
    bool shadow = false, within = false, mirrored = true, below = false;
    uint body = 0u, depth = 0u;
    vec3 loss = vec3(0.0);
    for (uint turn = 0u; turn < 200u && depth < 48u; ++turn) {
        bool found;
        RxHit hit;
        vec3 normal;
        if (within) {
            // From boundary to boundary of the body, without the tracer.
            RxBodyEnd end;
            RxRay on = RX_RAY(ray);
            bool ended = rx_walk_body(on.cell, on.frac, on.dir, body, DEEPEST, end), stands = rx_instance_in_body(ray, end.t, hit);
            if (!ended && !stands) break;
            share *= exp(-loss * (stands ? hit.t : end.t));
            ++depth;
            if (!stands && (end.material == 0u || rx_material_properties(end.material).transparency > 0.0)) {
                // Back into the air (another clear body counts as air): through, or mirrored inside.
                normal = rx_normal(end.face);
                float cosine = -dot(on.dir, normal), bent = rx_fresnel_dielectric(cosine, 1.0 / push.index);
                if (rx_next(numbers) < bent) {
                    vec3 turned = reflect(on.dir, normal);
                    // The same place, seen from inside.
                    ray = rx_scene_ray(rx_ray_from_face(end.beyond, end.face, end.uv, turned));
                } else {
                    vec3 out_dir = refract(on.dir, normal, push.index);
                    uint axis = rx_face_axis(end.face);
                    RxRay from = rx_ray_from_face(end.beyond, end.face, end.uv, out_dir);
                    from.cell = end.beyond;
                    from.frac[axis] = 1.0 - from.frac[axis];
                    ray = rx_scene_ray(from);
                    within = false;
                    mirrored = true;
                    if (end.material != 0u) {
                        within = true;
                        body = end.material;
                        loss = rx_body_loss(rx_material_properties(body));
                    }
                }
                continue;
            }
            if (!stands) hit = RxHit(end.beyond, end.face, end.material, end.t, end.uv, 0u);
            found = true;
        } else {
            found = rx_trace_places(ray, hit);
            if (shadow) {
                shadow = false;
                if (!found) light += shadow_share * waiting;
                ray = later;
                within = below;
                below = false;
                continue;
            }
            ++depth;
            if (!found) {
                light += share * sky_radiance(RX_RAY(ray).dir, sun);
                break;
            }
            if (hit.face == RX_FACE_INSIDE) break;
        }
        normal = rx_place_normal(hit.voxel, hit.face);
        RxMaterial material = rx_material_properties(hit.material);
        if (mirrored || rx_is_on_instance(hit.face)) light += share * material.albedo * frame.lamp_strength * material.emission;
        if (max(share.x, max(share.y, share.z)) < 1e-4) break;
        if (depth > 4u) {
            float on = clamp(max(share.x, max(share.y, share.z)), 0.05, 0.95);
            if (rx_next(numbers) >= on) break;
            share /= on;
        }
        vec3 v = -RX_RAY(ray).dir;
        if (!within && material.transparency > 0.0 && !rx_is_on_instance(hit.face)) {
            float bent = rx_fresnel_dielectric(max(dot(v, normal), 1e-3), push.index);
            if (rx_next(numbers) < bent) {
                ray = rx_ray_from_place(hit.voxel, hit.face, hit.uv, reflect(-v, normal));
            } else {
                vec3 inward = refract(-v, normal, 1.0 / push.index);
                RxRay from = rx_ray_from_face(hit.voxel, hit.face, hit.uv, inward);
                uint axis = rx_face_axis(hit.face);
                from.cell = hit.voxel;
                from.frac[axis] = 1.0 - from.frac[axis];
                ray = rx_scene_ray(from);
                within = true;
                body = hit.material;
                loss = rx_body_loss(material);
            }
            mirrored = true;
            continue;
        }
        // A coat or a metal mirrors; everything else is matt.
        float alpha = rx_ggx_alpha(material.roughness);
        vec3 f0 = mix(vec3(0.04), material.albedo, material.metallic), t, b;
        rx_basis(normal, t, b);
        vec3 local = to_frame(v, t, b, normal);
        local.z = max(local.z, 1e-3);
        float mirrors = mix(material.roughness < 0.9 ? rx_fresnel(vec3(0.04), local.z).x : 0.0, 1.0, material.metallic);
        if (rx_next(numbers) < mirrors) {
            vec3 h = rx_ggx_visible_normal(local, alpha, rx_next2(numbers)), l = reflect(-local, h);
            // The sun is met by a ray of its own: mirrored rays see the sky without its disc. Where the eye sees a matt surface that is lit so, it is a
            // caustic, which would take very many paths.
            vec3 to = rx_sun_point(sun, rx_next2(numbers)), s = to_frame(to, t, b, normal);
            shadow = mirrored && !within && s.z > 0.0;
            if (shadow) {
                vec3 between = normalize(s + local);
                vec3 f = mix(vec3(1.0), rx_fresnel(f0, dot(local, between)), material.metallic);
                waiting = f * rx_ggx_distribution(between.z, alpha) * rx_ggx_visibility(s.z, local.z, alpha) * s.z * sun_irradiance(sun);
                shadow_share = share;
            }
            if (l.z <= 0.0) share = vec3(0.0);
            else share *= mix(vec3(1.0), rx_fresnel(f0, dot(local, h)), material.metallic) * rx_ggx_kept(l, local, alpha);
            mirrored = true;
            later = rx_ray_from_place(hit.voxel, hit.face, hit.uv, l.x * t + l.y * b + l.z * normal);
            ray = shadow ? rx_ray_from_place(hit.voxel, hit.face, hit.uv, to) : later;
            continue;
        }
        share *= material.albedo;
        vec3 on = rx_place_vector(hit.voxel, hit.face, rx_cosine_direction(RX_FACE_PART(hit.face), rx_next2(numbers)));
        later = rx_ray_from_place(hit.voxel, hit.face, hit.uv, on);
        RxSceneRay start = rx_ray_from_place(hit.voxel, hit.face, hit.uv, normal);
        RxRay from = RX_RAY(start);
        mirrored = false;
        shadow_share = share;
        if (within) {
            RxRay upward;
            waiting = sun_below(start, normal, sun, body, loss, upward);
            ray = rx_scene_ray(upward);
            shadow = waiting != vec3(0.0);
            if (shadow) {
                below = true;
                within = false;
            } else ray = later;
            continue;
        }
        // One of the sun and a lamp, each half of the time where there are lamps.
        bool lamp = rx_lights_count() > 0u && rx_next(numbers) < 0.5;
        float times = rx_lights_count() > 0u ? 2.0 : 1.0;
        if (lamp) {
            RxLampSample chosen = rx_resample_lamps(4u, numbers, from, normal, 0.0);
            waiting = times * frame.lamp_strength * chosen.light;
            ray = start;
            RX_RAY(ray) = rx_lamp_ray(from, chosen.to);
        } else {
            vec3 to = rx_sun_point(sun, rx_next2(numbers));
            waiting = times * sun_irradiance(sun) * (max(dot(normal, to), 0.0) / RX_PI);
            ray = start;
            RX_RAY(ray).dir = to;
        }
        shadow = waiting != vec3(0.0);
        if (!shadow) ray = later;
    }
    return light;
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), size = imageSize(sum);
    if (any(greaterThanEqual(pixel, size))) return;
    if (frame.still >= uint(push.frames)) return;   // what is there stays
    vec4 all = vec4(path(pixel, size), 1.0);
    if (frame.still > 0u) all += imageLoad(sum, pixel);
    imageStore(sum, pixel, all);
    imageStore(outRadiance, pixel, vec4(all.rgb / all.w, 1.0));
}
