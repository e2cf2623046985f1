// A path tracer for materials. At each surface it draws one way for the light: a mirror image in a coat or a metal (GGX), or
// light from inside (matt). At a clear body, Fresnel's law chooses between a mirror image and the way through. Inside a body the
// way goes from boundary to boundary; light is taken away by its colour. Instances are seen everywhere, also in bodies of the world.
// A body may be one of an instance: the way follows its model, and nothing else in it is seen. No lamp is drawn on instances.
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

// A path on its way.
struct Path {
    RxSampler numbers;
    vec3 light;          // found so far
    vec3 share;          // of light at the path's end that comes back to the camera
    RxSceneRay ray;      // in work
    bool within;         // it is in a body:
    RxHit inner;         // of an instance, if this place is on one. The way goes on from there, in the direction of the ray,
    uint body;           // its material,
    vec3 loss;           // and its loss a voxel
    uint depth;          // surfaces that the path has met
    bool mirrored;       // the last one mirrored or refracted it, so a lamp that it meets counts
    // A ray to a light takes its turn before the path goes on.
    bool shadow;
    vec3 waiting;        // light along it, if nothing is in its way
    vec3 shadow_share;   // the path's share of that light
    RxSceneRay later;    // the ray that continues the path afterwards,
    bool below;          // and whether that one is in the body
};

const uint MEETS = 0u, GOES_ON = 1u, ENDS = 2u;   // the outcome of a ray: it met a surface, became another ray, or ended the path

// Sends the path through a face of a voxel, into that voxel.
void pass_face(inout Path path, ivec3 voxel, uint face, vec2 uv, vec3 dir) {
    path.inner = RxHit(voxel, face, 0u, 0.0, uv, 0u);
    if (rx_is_on_instance(face)) {
        RX_RAY(path.ray).dir = dir;
        return;
    }
    uint axis = rx_face_axis(face);
    RxRay from = rx_ray_from_face(voxel, face, uv, dir);
    from.cell = voxel;
    from.frac[axis] = 1.0 - from.frac[axis];
    path.ray = rx_scene_ray(from);
}

void enter_body(inout Path path, uint body) {
    path.within = true;
    path.body = body;
    path.loss = rx_body_loss(rx_material_properties(body));
}

// From boundary to boundary of the body, without the tracer.
uint cross_body(inout Path path, out RxHit hit) {
    RxBodyEnd end;
    RxRay on = RX_RAY(path.ray);
    bool moves = rx_is_on_instance(path.inner.face), ended, stands = false;
    if (moves) {
        ended = rx_walk_instance_body(path.inner.voxel, path.inner.face, path.inner.uv, on.dir, path.body, DEEPEST, end);
    } else {
        ended = rx_walk_body(on.cell, on.frac, on.dir, path.body, DEEPEST, end);
        stands = rx_instance_in_body(path.ray, end.t, hit);
    }
    if (!ended && !stands) return ENDS;
    path.share *= exp(-path.loss * (stands ? hit.t : end.t));
    ++path.depth;
    if (!stands && (end.material == 0u || rx_material_properties(end.material).transparency > 0.0)) {
        // Back into the air (another clear body counts as air): through, or mirrored inside.
        vec3 normal = rx_place_normal(end.inside, end.face);
        float cosine = -dot(on.dir, normal), bent = rx_fresnel_dielectric(cosine, 1.0 / push.index);
        if (rx_next(path.numbers) < bent) {
            vec3 turned = reflect(on.dir, normal);
            // The same place, seen from inside.
            if (moves) pass_face(path, end.inside, end.face ^ 1u, end.uv, turned);
            else path.ray = rx_scene_ray(rx_ray_from_face(end.beyond, end.face, end.uv, turned));
        } else {
            vec3 outward = refract(on.dir, normal, push.index);
            pass_face(path, end.beyond, end.face, end.uv, outward);
            if (moves) path.ray = rx_ray_from_place(end.inside, end.face ^ 1u, end.uv, outward);
            path.within = false;
            path.mirrored = true;
            if (end.material != 0u) enter_body(path, end.material);
        }
        return GOES_ON;
    }
    if (!stands) hit = RxHit(end.beyond, end.face, end.material, end.t, end.uv, 0u);
    if (moves) path.inner = RxHit(end.inside, end.face ^ 1u, 0u, 0.0, end.uv, 0u);
    return MEETS;
}

// Through the air, by the tracer.
uint cross_air(inout Path path, vec3 sun, out RxHit hit) {
    bool found = rx_trace_places(path.ray, hit);
    if (path.shadow) {
        path.shadow = false;
        if (!found) path.light += path.shadow_share * path.waiting;
        path.ray = path.later;
        path.within = path.below;
        path.below = false;
        return GOES_ON;
    }
    ++path.depth;
    if (!found) {
        path.light += path.share * sky_radiance(RX_RAY(path.ray).dir, sun);
        return ENDS;
    }
    return hit.face == RX_FACE_INSIDE ? ENDS : MEETS;
}

// Off the surface of a clear body, or into it, by Fresnel's law.
void meet_clear(inout Path path, RxHit hit, vec3 normal, vec3 v) {
    float bent = rx_fresnel_dielectric(max(dot(v, normal), 1e-3), push.index);
    if (rx_next(path.numbers) < bent) {
        path.ray = rx_ray_from_place(hit.voxel, hit.face, hit.uv, reflect(-v, normal));
    } else {
        pass_face(path, hit.voxel, hit.face, hit.uv, refract(-v, normal, 1.0 / push.index));
        enter_body(path, hit.material);
    }
    path.mirrored = true;
}

// Off a coat or a metal, if the next random number is below their share. False if the surface is matt to this path.
bool meet_mirror(inout Path path, RxHit hit, RxMaterial material, vec3 normal, vec3 v, vec3 sun) {
    float alpha = rx_ggx_alpha(material.roughness);
    vec3 f0 = mix(vec3(0.04), material.albedo, material.metallic), t, b;
    rx_basis(normal, t, b);
    vec3 local = to_frame(v, t, b, normal);
    local.z = max(local.z, 1e-3);
    float mirrors = mix(material.roughness < 0.9 ? rx_fresnel(vec3(0.04), local.z).x : 0.0, 1.0, material.metallic);
    if (rx_next(path.numbers) >= mirrors) return false;
    vec3 h = rx_ggx_visible_normal(local, alpha, rx_next2(path.numbers)), l = reflect(-local, h);
    // A ray of its own goes to the sun: mirrored rays see the sky without its disc. On a matt surface that the eye sees, such light is a
    // caustic, which would take very many paths.
    vec3 to = rx_sun_point(sun, rx_next2(path.numbers)), s = to_frame(to, t, b, normal);
    path.shadow = path.mirrored && !path.within && s.z > 0.0;
    if (path.shadow) {
        vec3 between = normalize(s + local);
        vec3 f = mix(vec3(1.0), rx_fresnel(f0, dot(local, between)), material.metallic);
        path.waiting = f * rx_ggx_distribution(between.z, alpha) * rx_ggx_visibility(s.z, local.z, alpha) * s.z * sun_irradiance(sun);
        path.shadow_share = path.share;
    }
    if (l.z <= 0.0) path.share = vec3(0.0);
    else path.share *= mix(vec3(1.0), rx_fresnel(f0, dot(local, h)), material.metallic) * rx_ggx_kept(l, local, alpha);
    path.mirrored = true;
    path.later = rx_ray_from_place(hit.voxel, hit.face, hit.uv, l.x * t + l.y * b + l.z * normal);
    path.ray = path.shadow ? rx_ray_from_place(hit.voxel, hit.face, hit.uv, to) : path.later;
    return true;
}

// On from a matt surface in any direction, after a ray to a light.
void meet_matt(inout Path path, RxHit hit, RxMaterial material, vec3 normal, vec3 sun) {
    path.share *= material.albedo;
    vec3 on = rx_place_vector(hit.voxel, hit.face, rx_cosine_direction(RX_FACE_PART(hit.face), rx_next2(path.numbers)));
    path.later = rx_ray_from_place(hit.voxel, hit.face, hit.uv, on);
    RxSceneRay start = rx_ray_from_place(hit.voxel, hit.face, hit.uv, normal);
    RxRay from = RX_RAY(start);
    path.mirrored = false;
    path.shadow_share = path.share;
    if (path.within && rx_is_on_instance(path.inner.face)) {
        path.shadow = false;   // sunlight in bodies of instances is left out
    } else if (path.within) {
        RxRay upward;
        path.waiting = sun_below(start, normal, sun, path.body, path.loss, upward);
        path.shadow = path.waiting != vec3(0.0);
        if (path.shadow) {
            path.ray = rx_scene_ray(upward);
            path.below = true;
            path.within = false;
            return;
        }
    } else {
        // One of the sun and a lamp, each half of the time where there are lamps.
        bool lamp = rx_lights_count() > 0u && rx_next(path.numbers) < 0.5;
        float times = rx_lights_count() > 0u ? 2.0 : 1.0;
        path.ray = start;
        if (lamp) {
            RxLampSample chosen = rx_resample_lamps(4u, path.numbers, from, normal, 0.0);
            path.waiting = times * frame.lamp_strength * chosen.light;
            RX_RAY(path.ray) = rx_lamp_ray(from, chosen.to);
        } else {
            vec3 to = rx_sun_point(sun, rx_next2(path.numbers));
            path.waiting = times * sun_irradiance(sun) * (max(dot(normal, to), 0.0) / RX_PI);
            RX_RAY(path.ray).dir = to;
        }
        path.shadow = path.waiting != vec3(0.0);
    }
    if (!path.shadow) path.ray = path.later;
}

vec3 path_light(ivec2 pixel, ivec2 size) {
    Path path;
    path.numbers = rx_sampler(frame.still, scene_seed(uint(pixel.x) + rx_hash(uint(pixel.y))));
    vec3 sun = frame_sun();
    vec3 dir = rx_camera_direction(frame.view_to_world, frame.tan_half_fov, vec2(pixel) + rx_next2(path.numbers), vec2(size));
    path.light = path.waiting = path.shadow_share = path.loss = vec3(0.0);
    path.share = vec3(1.0);
    path.ray = rx_scene_ray(rx_ray(frame.camera_cell, frame.camera_frac, dir));
    path.shadow = path.within = path.below = false;
    path.mirrored = true;
    path.body = path.depth = 0u;
    path.inner = RxHit(ivec3(0), RX_FACE_INSIDE, 0u, 0.0, vec2(0.0), 0u);
    for (uint turn = 0u; turn < 200u && path.depth < 48u; ++turn) {
        RxHit hit;
        uint done = path.within ? cross_body(path, hit) : cross_air(path, sun, hit);
        if (done == ENDS) break;
        if (done == GOES_ON) continue;
        vec3 normal = rx_place_normal(hit.voxel, hit.face);
        RxMaterial material = rx_material_properties(hit.material);
        if (path.mirrored || rx_is_on_instance(hit.face)) path.light += path.share * material.albedo * frame.lamp_strength * material.emission;
        if (max(path.share.x, max(path.share.y, path.share.z)) < 1e-4) break;
        if (path.depth > 4u) {
            float on = clamp(max(path.share.x, max(path.share.y, path.share.z)), 0.05, 0.95);
            if (rx_next(path.numbers) >= on) break;
            path.share /= on;
        }
        vec3 v = -RX_RAY(path.ray).dir;
        if (!path.within && material.transparency > 0.0) meet_clear(path, hit, normal, v);
        else if (!meet_mirror(path, hit, material, normal, v, sun)) meet_matt(path, hit, material, normal, sun);
    }
    return path.light;
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), size = imageSize(sum);
    if (any(greaterThanEqual(pixel, size))) return;
    if (frame.still >= uint(push.frames)) return;   // the sum stays
    vec4 all = vec4(path_light(pixel, size), 1.0);
    if (frame.still > 0u) all += imageLoad(sum, pixel);
    imageStore(sum, pixel, all);
    imageStore(outRadiance, pixel, vec4(all.rgb / all.w, 1.0));
}
