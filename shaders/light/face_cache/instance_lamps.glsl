// Lamps on instances: faces of their models that give off light. A face is a place on an instance (<raxel/place.glsl>), so nothing here changes while instances move. The
// list is in the buffer of the instances. Its first quad has the sum of all powers. Each instance with lamps has two quads: its index, the first face of its
// model and the number of faces; then how it is drawn. Each face has two quads: voxel, material of the model + face << 16; then how it is drawn. Needs
// <raxel/scene.glsl>, <raxel/light/lamps.glsl>, and instances that are bound.
#ifndef LIGHT_INSTANCE_LAMPS_GLSL
#define LIGHT_INSTANCE_LAMPS_GLSL

uvec4 instance_lamps_quad(uint at) {
    return instances.quads[instances.lamps_at + at];
}

// The probability by area of a face with this radiance in draw_instance_lamp.
float instance_lamp_probability(vec3 radiance) {
    return instances.lamps == 0u ? 0.0 : rx_luminance(radiance) / uintBitsToFloat(instance_lamps_quad(0u).x);
}

// One of `count` things with two quads each, drawn in proportion to power: the index. `random` is a number in [0, 1).
uint instance_lamps_pick(uint first, uint count, float random) {
    float place = random * float(count);
    uint index = min(uint(place), count - 1u);
    uvec4 draw = instance_lamps_quad(first + 2u * index + 1u);
    return place - float(index) < uintBitsToFloat(draw.x) ? index : draw.y;
}

// A face, drawn in proportion to its power, and a place on it. There are lamps. Draws a pair.
RxLight draw_instance_lamp(inout RxSampler s, out vec2 uv) {
    vec2 u = rx_next2(s);
    uint more = rx_hash(s.seed ^ rx_hash(s.index + 0x10001u * s.pair)), across = rx_hash(more);
    uint chosen = instance_lamps_pick(1u, instances.lamps, u.x);
    uvec4 of = instance_lamps_quad(1u + 2u * chosen);
    uint at = of.y + 2u * instance_lamps_pick(of.y, of.z, float(more >> 8) * 5.9604644775390625e-8);
    uvec4 face = instance_lamps_quad(at);
    uv = vec2(float(across >> 8) * 5.9604644775390625e-8, u.y);
    ivec3 voxel = ivec3(face.xyz);
    voxel.x |= int(of.x << RX_PLACE_BITS);
    // The palette of the model says which material of the world that is.
    uint material = rx_instance_word(rx_instance_of(of.x), 8u * (face.w & 0xffffu) + 7u);
    return RxLight(voxel, face.w >> 16 | RX_ON_INSTANCE, material, 0.0, 1.0);
}

// The point of a lamp, from a point in a cell, and the lamp's normal there. In floats: a ray to the point asks which voxel it meets.
vec3 instance_lamp_to(RxLight lamp, vec2 uv, ivec3 cell, vec3 frac, out vec3 normal) {
    RxInstance instance = rx_instance_of(rx_place_instance(lamp.voxel));
    uint face = RX_FACE_PART(lamp.face);
    float size = float(1u << (instance.shape & 31u));
    vec3 place = rx_unturned(instance, vec3(rx_place_cell(lamp.voxel)) + rx_face_place(face, uv), size);
    normal = rx_unturned(instance, rx_normal(face), 0.0);
    if (!rx_instance_is_free(instance)) return vec3(instance.corner - cell) + (place - frac);
    // The corner counts from the anchor's cell, and the rotation is about its centre.
    normal = rx_direction_from_instance(instance, normal);
    vec3 turned = rx_direction_from_instance(instance, vec3(instance.corner) + place - 0.5);
    return vec3(instance.cell - cell) + (turned + vec3(instance.fraction) * 5.9604644775390625e-8 - frac);
}

#endif
