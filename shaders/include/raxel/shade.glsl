// Light on voxel faces. Needs <raxel/world.glsl> first.
#ifndef RAXEL_SHADE_GLSL
#define RAXEL_SHADE_GLSL

#include "sky.glsl"
#include "random.glsl"

// Whether a face sees the sun. The ray starts exactly on the face, so it needs no bias and shows no acne.
bool rx_sees_sun(RxHit hit, vec3 sun) {
    RxHit unused;
    return dot(rx_normal(hit.face), sun) > 0.0 && !rx_trace(rx_ray_from_face(hit.voxel, hit.face, hit.uv, sun), unused);
}

// Share of the light that reaches a corner of a face, by the solid voxels at its two sides and at the corner.
float rx_corner_light(bool side_a, bool side_b, bool corner) {
    const float light[4] = float[](1.0, 0.74, 0.55, 0.40);
    return light[side_a && side_b ? 3 : int(side_a) + int(side_b) + int(corner)];
}

// The openness of a point of a face to the sky, 0 to 1. The eight voxels around it in the layer above darken its corners (Lysenko, "Ambient
// occlusion for Minecraft-like worlds", 2013), blended over the face.
float rx_openness(RxHit hit) {
    ivec3 u, v;
    rx_face_tangents(hit.face, u, v);
    ivec3 above = hit.voxel + rx_face_step(hit.face);
    // One look-up in a loop, not eight in a row: every call is inlined, and drivers would compile the tree walk eight times.
    uint solid = 0u;
    for (int i = 0; i < 9; ++i) {
        if (rx_material(above + (i % 3 - 1) * u + (i / 3 - 1) * v) != 0u) solid |= 1u << i;
    }
    bool b = (solid & 2u) != 0u, l = (solid & 8u) != 0u, r = (solid & 32u) != 0u, t = (solid & 128u) != 0u;
    vec4 corners = vec4(rx_corner_light(l, b, (solid & 1u) != 0u), rx_corner_light(r, b, (solid & 4u) != 0u),
                        rx_corner_light(l, t, (solid & 64u) != 0u), rx_corner_light(r, t, (solid & 256u) != 0u));
    return mix(mix(corners.x, corners.y, hit.uv.x), mix(corners.z, corners.w, hit.uv.x), hit.uv.y);
}

// Light of the sky and the ground on a face that sees all of both.
vec3 rx_ambient(vec3 normal, vec3 sun) {
    vec3 from_sky = rx_sky(normalize(normal + vec3(0.0, 0.6, 0.0)), sun);
    vec3 from_ground = vec3(0.20, 0.17, 0.13) * (0.25 + 0.75 * rx_sun_color(sun)) * max(sun.y, 0.05);
    return mix(from_ground, from_sky, 0.5 + 0.5 * normal.y) * (normal.x != 0.0 ? 0.86 : normal.z != 0.0 ? 0.94 : 1.0);
}

// Whether a surface is smooth enough to mirror its surroundings.
bool rx_mirrors(RxMaterial material) {
    return material.roughness < 0.5;
}

// Packs material, face and whether the sun is visible into one word that is not negative.
int rx_pack_surface(uint material, uint face, bool sunlit) {
    return int(material | (face << 16) | (sunlit ? 1u << 19 : 0u));
}

// The material in a word of rx_pack_surface.
uint rx_packed_material(int word) {
    return uint(word) & 0xffffu;
}

// The face in a word of rx_pack_surface.
uint rx_packed_face(int word) {
    return (uint(word) >> 16) & 7u;
}

// Whether the surface in a word of rx_pack_surface is in the sun.
bool rx_packed_sunlit(int word) {
    return (uint(word) & (1u << 19)) != 0u;
}

// A few per cent of difference between neighbouring voxels, so that large flat areas do not look like plastic.
float rx_grain(ivec3 voxel) {
    return 0.95 + 0.10 * float(rx_hash(voxel) >> 8) * 5.9604644775390625e-8;
}

// A filmic curve from linear light to linear display values in 0 to 1 (Narkowicz, "ACES filmic tone mapping curve", 2015).
vec3 rx_tone_curve(vec3 light) {
    return clamp(light * (2.51 * light + 0.03) / (light * (2.43 * light + 0.59) + 0.14), 0.0, 1.0);
}

#endif
