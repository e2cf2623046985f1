// The world, with its instances where a pass binds them. A buffer with `source = "world.instances"` and `when = "world.has_instances"` that is
// bound as `instances` defines RX_BINDS_instances. Then the names below stand for the world and its instances (instances.glsl). In all other
// passes they are those of the world alone, and cost nothing.
//
// A place on a surface is a voxel, a face and `uv` on it, as in RxHit. On an instance, the face has RX_ON_INSTANCE, and voxel, face and `uv` are
// those of the model: they stay the same while the instance moves. Such a voxel counts from the corner of the model's cube, and the
// upper bits of its x are the number of the instance.
//
//     RxSceneRay rx_scene_ray(RxRay ray);                               a ray that begins anywhere; RX_RAY(ray) is that ray again
//     bool rx_trace_places(RxSceneRay ray, out RxHit hit);              the first solid voxel along a ray, as a place
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

#include "instances.glsl"

const uint RX_ON_INSTANCE = 8u;
#define RX_RAY(scene_ray) (scene_ray).ray
#define RX_FACE_PART(face) ((face) & 7u)
#define RX_FACE_MASK 15u

const uint RX_PLACE_BITS = 18u;   // of a cell in the cube of a model; the other 14 are the number of the instance

bool rx_is_on_instance(uint face) {
    return (face & RX_ON_INSTANCE) != 0u;
}

uint rx_place_instance(ivec3 voxel) {
    return uint(voxel.x) >> RX_PLACE_BITS;
}

ivec3 rx_place_cell(ivec3 voxel) {
    return ivec3(voxel.x & ((1 << RX_PLACE_BITS) - 1), voxel.yz);
}

// Where a place on a face lies in the cube of its voxel, and back.
vec3 rx_face_place(uint face, vec2 uv) {
    uint axis = rx_face_axis(face);
    float plane = float(face & 1u);
    return axis == 0u ? vec3(plane, uv) : axis == 1u ? vec3(uv.x, plane, uv.y) : vec3(uv, plane);
}

vec2 rx_face_uv(uint face, vec3 place) {
    uint axis = rx_face_axis(face);
    return axis == 0u ? place.yz : axis == 1u ? place.xz : place.xy;
}

// A vector in the axes of a model, in those of the frame that the instance is walked in; `rest` is what a component is taken from that is turned around.
vec3 rx_unturned(RxInstance instance, vec3 v, float rest) {
    vec3 turned = vec3(0.0);
    for (uint axis = 0u; axis < 3u; ++axis) {
        turned[rx_instance_axis(instance, axis)] = rx_instance_turns_around(instance, axis) ? rest - v[axis] : v[axis];
    }
    return turned;
}

uint rx_unturned_face(RxInstance instance, uint face) {
    uint axis = rx_face_axis(face);
    return 2u * rx_instance_axis(instance, axis) + ((face & 1u) ^ (rx_instance_turns_around(instance, axis) ? 1u : 0u));
}

vec3 rx_instance_vector(RxInstance instance, vec3 v) {
    vec3 turned = rx_unturned(instance, v, 0.0);
    return rx_instance_is_free(instance) ? rx_direction_from_instance(instance, turned) : turned;
}

vec3 rx_place_vector(ivec3 voxel, uint face, vec3 v) {
    return rx_is_on_instance(face) ? rx_instance_vector(rx_instance_of(rx_place_instance(voxel)), v) : v;
}

vec3 rx_place_normal(ivec3 voxel, uint face) {
    return rx_place_vector(voxel, face, rx_normal(RX_FACE_PART(face)));
}

// A ray that leaves a place on an instance whose pose is given.
RxSceneRay rx_ray_from_instance(RxInstance instance, ivec3 voxel, uint face, vec2 uv, vec3 dir) {
    uint side = rx_unturned_face(instance, RX_FACE_PART(face));
    vec2 on_side = rx_face_uv(side, rx_unturned(instance, rx_face_place(RX_FACE_PART(face), uv), 1.0));
    vec3 cell = rx_unturned(instance, vec3(rx_place_cell(voxel)), float((1u << (instance.shape & 31u)) - 1u));
    RxRay start = rx_ray_from_face(instance.corner + ivec3(cell), side, on_side, dir);
    if (!rx_instance_is_free(instance)) return rx_scene_ray(start);
    return rx_scene_ray_from_instance(instance, rx_place_instance(voxel), start, dir);
}

RxSceneRay rx_ray_from_place(ivec3 voxel, uint face, vec2 uv, vec3 dir) {
    if (!rx_is_on_instance(face)) return rx_scene_ray(rx_ray_from_face(voxel, face, uv, dir));
    return rx_ray_from_instance(rx_instance_of(rx_place_instance(voxel)), voxel, face, uv, dir);
}

// What was hit, as a place.
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
    found = rx_trace_instances_on(rx_scene_ray(ray), found, first, nearest);
    hit = rx_place_of(nearest);
    return found;
}

#endif
#endif
