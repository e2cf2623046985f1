// Inside a clear body: a run of voxels of one material, such as glass or water. Needs <raxel/world.glsl>.
#ifndef RAXEL_LIGHT_BODY_GLSL
#define RAXEL_LIGHT_BODY_GLSL

#include "../ray.glsl"
#ifdef RX_BINDS_instances
#include "../scene.glsl"
#endif

// The end of a way through a body.
struct RxBodyEnd {
    ivec3 inside;   // the last voxel of the body
    ivec3 beyond;   // the first cell that is not of it
    uint face;      // the face of `beyond` that was reached
    vec2 uv;        // place on it
    float t;        // in lengths of the direction
    uint material;  // of `beyond`; 0 is air
};

// Walks from cell to cell, from a point in a voxel of the material `body`, until the material changes; false if it does not change within `most`
// cells. It is a plain grid walk in floats: unlike rx_trace, it may pass an edge on the wrong side.
bool rx_walk_body(ivec3 cell, vec3 frac, vec3 dir, uint body, uint most, out RxBodyEnd end) {
    ivec3 start = cell, way = ivec3(mix(vec3(-1.0), vec3(1.0), greaterThan(dir, vec3(0.0))));
    vec3 each = 1.0 / max(abs(dir), vec3(1e-9));
    vec3 next = mix(frac, 1.0 - frac, greaterThan(dir, vec3(0.0))) * each;
    end = RxBodyEnd(cell, cell, RX_FACE_INSIDE, vec2(0.5), 0.0, body);
    for (uint i = 0u; i < most; ++i) {
        uint axis = next.x <= next.y && next.x <= next.z ? 0u : next.y <= next.z ? 1u : 2u;
        end.t = next[axis];
        next[axis] += each[axis];
        end.inside = cell;
        cell[axis] += way[axis];
        end.material = rx_material(cell);
        if (end.material == body) continue;
        end.beyond = cell;
        end.face = 2u * axis + (way[axis] < 0 ? 1u : 0u);
        vec3 place = clamp(frac + end.t * dir - vec3(cell - start), 0.0, 1.0);
        end.uv = axis == 0u ? place.yz : axis == 1u ? place.xz : place.xy;
        return true;
    }
    return false;
}

#ifdef RX_BINDS_instances
// The first place on an instance along a ray that stays in a body as far as `most`, in lengths of the direction.
bool rx_instance_in_body(RxSceneRay ray, float most, out RxHit hit) {
    RX_RAY(ray).t_max = most;
    RxSceneHit nearest = RxSceneHit(RxHit(ivec3(0), 0u, 0u, 0.0, vec2(0.0), 0u), RX_NO_INSTANCE, false, ivec3(0), 0u);
    bool found = rx_trace_instances_on(ray, false, false, RxTime(uvec2(0u), 1u), nearest);
    hit = rx_place_of(nearest);
    return found;
}
#else
#define rx_instance_in_body(ray, most, hit) false
#endif

// Loss of light in a body per voxel: a coloured body takes away the other colours, and the clearer it is, the less.
vec3 rx_body_loss(RxMaterial material) {
    return -log(clamp(material.albedo, 0.02, 0.99)) * mix(0.4, 0.04, material.transparency);
}

// Continues a ray straight through clear bodies, such as panes of glass. It passes at most four bodies of at most `most` cells each, and
// must end in air. Then `ray` begins behind them and ends where it ended, and `share` is less their loss. Their surfaces mirror nothing
// here.
bool rx_pass_body(RxHit hit, uint most, inout RxRay ray, inout vec3 share) {
    if (hit.face == RX_FACE_INSIDE) return false;
    // From the same place, but into the voxel.
    RxRay at = rx_ray_from_face(hit.voxel, hit.face, hit.uv, ray.dir);
    uint axis = rx_face_axis(hit.face), body = hit.material;
    at.cell = hit.voxel;
    at.frac[axis] = 1.0 - at.frac[axis];
    at.t_max = ray.t_max - hit.t;
    vec3 left = vec3(1.0);
    for (int i = 0; i < 4; ++i) {
        RxMaterial material = rx_material_properties(body);
        RxBodyEnd end;
        if (material.transparency <= 0.0 || !rx_walk_body(at.cell, at.frac, ray.dir, body, most, end)) return false;
        left *= exp(-rx_body_loss(material) * (end.t * length(ray.dir)));
        float rest = at.t_max - end.t;
        // A ray that leaves the last voxel of the body begins in the cell behind it.
        at = rx_ray_from_face(end.inside, end.face ^ 1u, end.uv, ray.dir);
        at.t_max = rest;
        body = end.material;
        if (body == 0u) {
            ray = at;
            share *= left;
            return true;
        }
    }
    return false;
}

#ifdef RX_BINDS_instances
// The same along a ray through the world and its instances (<raxel/scene.glsl>), which are not passed.
bool rx_pass_panes(RxHit hit, uint most, inout RxSceneRay ray, inout vec3 share) {
    if (rx_is_on_instance(hit.face)) return false;
    RxRay on = ray.ray;
    bool passes = rx_pass_body(hit, most, on, share);
    if (passes) ray = rx_scene_ray(on);
    return passes;
}
#else
#define rx_pass_panes(hit, most, ray, share) rx_pass_body(hit, most, ray, share)
#endif

#endif
