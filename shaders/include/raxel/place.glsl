// Places on instances. The face of such a place has the bit RX_ON_INSTANCE. Its voxel, face and `uv` are those of the model, so they stay the same
// while the instance moves. The voxel counts from the corner of the model's cube. The upper bits of its x are the number of the instance.
// A face without that bit belongs to the world. Nothing here traces: see scene.glsl.
#ifndef RAXEL_PLACE_GLSL
#define RAXEL_PLACE_GLSL

#include "instance_frame.glsl"

const uint RX_ON_INSTANCE = 8u;
#define RX_RAY(scene_ray) (scene_ray).ray
#define RX_FACE_PART(face) ((face) & 7u)
#define RX_FACE_MASK 15u

const uint RX_PLACE_BITS = 18u;   // of a cell in the cube of a model; the other 14 are the number of the instance

// Whether the face of a place is on an instance.
bool rx_is_on_instance(uint face) {
    return (face & RX_ON_INSTANCE) != 0u;
}

// The index of the instance that the voxel of a place is on.
uint rx_place_instance(ivec3 voxel) {
    return uint(voxel.x) >> RX_PLACE_BITS;
}

// The cell of the voxel of a place, in the cube of the instance's model.
ivec3 rx_place_cell(ivec3 voxel) {
    return ivec3(voxel.x & ((1 << RX_PLACE_BITS) - 1), voxel.yz);
}

// Maps a place on a face to a place in the cube of its voxel.
vec3 rx_face_place(uint face, vec2 uv) {
    uint axis = rx_face_axis(face);
    float plane = float(face & 1u);
    return axis == 0u ? vec3(plane, uv) : axis == 1u ? vec3(uv.x, plane, uv.y) : vec3(uv, plane);
}

// The inverse of rx_face_place.
vec2 rx_face_uv(uint face, vec3 place) {
    uint axis = rx_face_axis(face);
    return axis == 0u ? place.yz : axis == 1u ? place.xz : place.xy;
}

// Turns a vector from the axes of a model to those of the frame in which the instance is walked. A component c on a reversed axis becomes `rest` - c.
vec3 rx_unturned(RxInstance instance, vec3 v, float rest) {
    vec3 turned = vec3(0.0);
    for (uint axis = 0u; axis < 3u; ++axis) {
        turned[rx_instance_axis(instance, axis)] = rx_instance_turns_around(instance, axis) ? rest - v[axis] : v[axis];
    }
    return turned;
}

// Turns a face from the axes of a model to those of the frame in which the instance is walked.
uint rx_unturned_face(RxInstance instance, uint face) {
    uint axis = rx_face_axis(face);
    return 2u * rx_instance_axis(instance, axis) + ((face & 1u) ^ (rx_instance_turns_around(instance, axis) ? 1u : 0u));
}

// A vector in the axes of a model, in those of the world.
vec3 rx_instance_vector(RxInstance instance, vec3 v) {
    vec3 turned = rx_unturned(instance, v, 0.0);
    return rx_instance_is_free(instance) ? rx_direction_from_instance(instance, turned) : turned;
}

// A vector in the axes of the voxel of a place, in those of the world.
vec3 rx_place_vector(ivec3 voxel, uint face, vec3 v) {
    return rx_is_on_instance(face) ? rx_instance_vector(rx_instance_of(rx_place_instance(voxel)), v) : v;
}

// The outward normal of the face of a place, in the world.
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

// A ray that leaves a place in a direction of the world.
RxSceneRay rx_ray_from_place(ivec3 voxel, uint face, vec2 uv, vec3 dir) {
    if (!rx_is_on_instance(face)) return rx_scene_ray(rx_ray_from_face(voxel, face, uv, dir));
    return rx_ray_from_instance(rx_instance_of(rx_place_instance(voxel)), voxel, face, uv, dir);
}

#endif
