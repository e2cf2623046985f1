// The lamps of the world: a list of the exposed faces of emissive voxels, and a table to draw one in proportion to its power.
// Bind `lights` to a buffer with `source = "world.lights"`. Each face gives off the same radiance everywhere and in all directions, albedo *
// emission. Its area is 1, but for the cells of a streamed world, which are as large as their level makes them. There, lamps come and go in
// groups: one is drawn first, and then a face of it.
#ifndef RAXEL_LIGHT_LIGHTS_GLSL
#define RAXEL_LIGHT_LIGHTS_GLSL

#include "../ray.glsl"

layout(std430) readonly buffer RxLights {
    uint count;
    uint power;  // the sum of all powers, as the bits of a float
    uint groups_at;  // of a streamed world: index of the first of its groups
    uint groups;     // their number; 0 where all faces are in one list
    uvec4 quads[];  // two for each light: voxel, material + face << 16 + level << 19; probability, threshold, alias, power by area
                    // one for each group: first light, lights, threshold, alias
} lights;

// A lamp: an exposed face of an emissive voxel or cell.
struct RxLight {
    ivec3 voxel;
    uint face;
    uint material;      // index for rx_material_properties
    float probability;  // of being drawn, by area
    float edge;         // length of its sides
};

// The number of lamps. The other functions need at least one.
uint rx_lights_count() {
    return lights.count;
}

// The lamp of an index, which is below rx_lights_count().
RxLight rx_light(uint index) {
    uvec4 place = lights.quads[2u * index], draw = lights.quads[2u * index + 1u];
    float probability =
        lights.groups == 0u ? uintBitsToFloat(draw.x) : uintBitsToFloat(draw.w) / uintBitsToFloat(lights.power);
    return RxLight(ivec3(place.xyz), place.w >> 16 & 7u, place.w & 0xffffu, probability, float(1u << 2u * (place.w >> 19)));
}

// Whether a place that a ray has hit is on a light.
bool rx_is_on_light(RxLight light, ivec3 voxel, uint face) {
    ivec3 from = voxel - light.voxel;
    return face == light.face && all(greaterThanEqual(from, ivec3(0))) && all(lessThan(from, ivec3(light.edge)));
}

// The index of a light, drawn in proportion to power; `random` are two numbers of 32 random bits. `rest` is the remainder of the first one:
// 32 random bits again, in steps of `spacing`.
uint rx_pick_light(uvec2 random, out uint rest, out uint spacing) {
    uint first = 0u, index;
    float keep = float(random.y >> 8) * 5.9604644775390625e-8;
    rest = random.x;
    spacing = lights.count;
    if (lights.groups > 0u) {
        uint number;
        umulExtended(rest, lights.groups, number, rest);
        uvec4 group = lights.quads[lights.groups_at + number];
        float threshold = uintBitsToFloat(group.z);
        bool stays = keep < threshold;
        // The number that decided is spread evenly again over the range that led to this decision.
        keep = stays ? keep / threshold : (keep - threshold) / (1.0 - threshold);
        if (!stays) group = lights.quads[lights.groups_at + group.w];
        first = group.x;
        spacing = group.y;
    }
    umulExtended(rest, spacing, index, rest);
    spacing *= max(lights.groups, 1u);
    index += first;
    uvec4 draw = lights.quads[2u * index + 1u];
    return keep < uintBitsToFloat(draw.y) ? index : draw.z;
}

// The same without the bits that are left.
uint rx_pick_light(uvec2 random) {
    uint rest, spacing;
    return rx_pick_light(random, rest, spacing);
}

// The probability by area of a face with this radiance in rx_pick_light; 0 without lamps.
float rx_light_probability(vec3 radiance) {
    float total = uintBitsToFloat(lights.power);
    return total > 0.0 ? dot(radiance, vec3(0.2126, 0.7152, 0.0722)) / total : 0.0;
}

// A point of a light's face as seen from a point in a cell; `uv` is the place on the face, 0 to 1.
vec3 rx_to_light(RxLight light, vec2 uv, ivec3 cell, vec3 frac) {
    uint axis = rx_face_axis(light.face);
    float plane = float(light.face & 1u);
    vec3 place = axis == 0u ? vec3(plane, uv) : axis == 1u ? vec3(uv.x, plane, uv.y) : vec3(uv, plane);
    return vec3(light.voxel - cell) + (place * light.edge - frac);
}

#endif
