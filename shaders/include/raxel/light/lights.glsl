// The lamps of the world: a list of the bare faces of emissive voxels, and a table that draws one of them in proportion to its power.
// Bind `lights` to a buffer with `source = "world.lights"`. Each face has the area 1 and gives off the same radiance,
// albedo * emission, in all directions.
#ifndef RAXEL_LIGHT_LIGHTS_GLSL
#define RAXEL_LIGHT_LIGHTS_GLSL

#include "../ray.glsl"

layout(std430) readonly buffer RxLights {
    uint count;
    uint power;  // the sum of all powers, as the bits of a float
    uint unused0;
    uint unused1;
    uvec4 quads[];  // two for each light: voxel, material + face << 16; probability, threshold, alias, power
} lights;

struct RxLight {
    ivec3 voxel;
    uint face;
    uint material;      // index for rx_material_properties
    float probability;  // of being drawn
};

// How many there are; the others of these functions are for worlds that have some.
uint rx_lights_count() {
    return lights.count;
}

RxLight rx_light(uint index) {
    uvec4 place = lights.quads[2u * index];
    return RxLight(ivec3(place.xyz), place.w >> 16, place.w & 0xffffu, uintBitsToFloat(lights.quads[2u * index + 1u].x));
}

// The index of a light, drawn in proportion to power; `random` are two numbers of 32 random bits.
uint rx_pick_light(uvec2 random) {
    uint index, low;
    umulExtended(random.x, lights.count, index, low);
    uvec4 draw = lights.quads[2u * index + 1u];
    return float(random.y >> 8) * 5.9604644775390625e-8 < uintBitsToFloat(draw.y) ? index : draw.z;
}

// The probability with which rx_pick_light gives a face that gives off this radiance; 0 where there is no lamp.
float rx_light_probability(vec3 radiance) {
    float total = uintBitsToFloat(lights.power);
    return total > 0.0 ? dot(radiance, vec3(0.2126, 0.7152, 0.0722)) / total : 0.0;
}

// A point of a light's face as seen from a point in a cell; `uv` is the place on the face, 0 to 1.
vec3 rx_to_light(RxLight light, vec2 uv, ivec3 cell, vec3 frac) {
    uint axis = rx_face_axis(light.face);
    float plane = float(light.face & 1u);
    vec3 place = axis == 0u ? vec3(plane, uv) : axis == 1u ? vec3(uv.x, plane, uv.y) : vec3(uv, plane);
    return vec3(light.voxel - cell) + (place - frac);
}

#endif
