// Traces the world, and its instances if the pass binds them. Bind `instances` to a buffer with `source = "world.instances"` and
// `when = "world.has_instances"`: this defines RX_BINDS_instances, and the names below trace the world and its instances (instances.glsl).
// In all other passes they trace the world alone, at no cost.
//
// A place on a surface is a voxel, a face and `uv` on it, as in RxHit; on an instance it is a place of its model (place.glsl).
//
//     RxSceneRay rx_scene_ray(RxRay ray);                               a ray that begins anywhere; RX_RAY(ray) is that ray again
//     bool rx_trace_places(RxSceneRay ray, out RxHit hit);              the first solid voxel along a ray, as a place
//     bool rx_meets_places(RxSceneRay ray);                             whether there is a solid voxel along a ray
//     vec3 rx_place_normal(ivec3 voxel, uint face);                     the outward normal there, in the world
//     RxSceneRay rx_ray_from_place(ivec3 voxel, uint face, vec2 uv, vec3 dir);   a ray that leaves the face in a direction of the world
//     vec3 rx_place_vector(ivec3 voxel, uint face, vec3 v);             a vector in the axes of the voxel, in those of the world
//     bool rx_is_on_instance(uint face);
#ifndef RAXEL_SCENE_GLSL
#define RAXEL_SCENE_GLSL

#include "world.glsl"

#ifndef RX_BINDS_instances

#define RxSceneRay RxRay
#define RX_RAY(scene_ray) (scene_ray)
#define rx_scene_ray(ray) (ray)
#define rx_trace_places(ray, hit) rx_trace(ray, hit)
#define rx_place_normal(voxel, face) rx_normal(face)
#define rx_ray_from_place(voxel, face, uv, dir) rx_ray_from_face(voxel, face, uv, dir)
#define rx_place_vector(voxel, face, v) (v)
#define rx_is_on_instance(face) false
// The face without the bit, and the bits that a face takes.
#define RX_FACE_PART(face) (face)
#define RX_FACE_MASK 7u

#else

#include "place.glsl"
#include "instances.glsl"

// The hit, as a place.
RxHit rx_place_of(RxSceneHit hit) {
    RxHit at = hit.at;
    if (hit.instance == RX_NO_INSTANCE || at.face == RX_FACE_INSIDE) return at;
    RxInstance instance = rx_instance_of(hit.instance);
    vec3 place = rx_face_place(at.face, at.uv), turned = vec3(0.0);
    for (uint axis = 0u; axis < 3u; ++axis) {
        float c = place[rx_instance_axis(instance, axis)];
        turned[axis] = rx_instance_turns_around(instance, axis) ? 1.0 - c : c;
    }
    at.face = hit.cell_face | RX_ON_INSTANCE;
    at.uv = rx_face_uv(hit.cell_face, turned);
    at.voxel = hit.cell - instance.model_corner;
    at.voxel.x |= int(hit.instance << RX_PLACE_BITS);
    return at;
}

// First solid voxel along a ray through the world and its instances, as a place.
bool rx_trace_places(RxSceneRay ray, out RxHit hit) {
    RxSceneHit found;
    bool there = rx_trace_scene(ray, found);
    hit = rx_place_of(found);
    return there;
}

// The same along a ray whose first hit in the world alone is known already.
bool rx_trace_places_on(RxRay ray, bool found, inout RxHit hit) {
    RxSceneHit nearest = RxSceneHit(hit, RX_NO_INSTANCE, false, hit.voxel, hit.face);
    RxTime first = RxTime(uvec2(0u), 1u);
    if (found) first = rx_time_of(ray, hit, rx_lattice_top(ray.dir));
    found = rx_trace_instances_on(rx_scene_ray(ray), false, found, first, nearest);
    hit = rx_place_of(nearest);
    return found;
}

#endif

// Whether there is a solid voxel along a ray, of the world or of its instances. This takes less time than to find the first one.
bool rx_meets_places(RxSceneRay ray) {
    RxHit hit;
    bool met = rx_trace(RX_RAY(ray), hit);
#ifdef RX_BINDS_instances
    RxSceneHit nearest = RxSceneHit(hit, RX_NO_INSTANCE, false, ivec3(0), 0u);
    if (!met) met = rx_trace_instances_on(ray, true, false, RxTime(uvec2(0u), 1u), nearest);
#endif
    return met;
}

#endif
