// Materials of the bound world. Included by the layouts, after the block that holds them.
#ifndef RAXEL_MATERIAL_GLSL
#define RAXEL_MATERIAL_GLSL

struct RxMaterial {
    vec3 albedo;         // linear reflectance
    float roughness;     // 0 mirror, 1 matt
    float metallic;      // 0 dielectric, 1 metal
    float emission;      // in multiples of albedo
    float transparency;  // 0 opaque, 1 clear
};

// 8 words a material: albedo, roughness, metallic, emission, transparency, one unused. An unknown index is pink.
RxMaterial rx_material_properties(uint material) {
    if (material >= world.material_count) return RxMaterial(vec3(1.0, 0.0, 0.5), 1.0, 0.0, 0.0, 0.0);
    uint at = world.materials_at + 8u * material;
    return RxMaterial(vec3(uintBitsToFloat(world.words[at]), uintBitsToFloat(world.words[at + 1u]),
                           uintBitsToFloat(world.words[at + 2u])),
                      uintBitsToFloat(world.words[at + 3u]), uintBitsToFloat(world.words[at + 4u]),
                      uintBitsToFloat(world.words[at + 5u]), uintBitsToFloat(world.words[at + 6u]));
}

#endif
