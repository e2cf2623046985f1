// The materials of voxels. In a world that moves (LIVE), voxels of two more kinds are among them that no world's file knows.
#ifdef LIVE
const uint GRASS_CELL = 0xfff0u;    // air with blades of grass
const uint SPARK = 0xfff1u;

RxMaterial matter(uint material) {
    if (material == GRASS_CELL) return RxMaterial(vec3(0.16, 0.33, 0.06), 1.0, 0.0, 0.0, 0.0);
    if (material == SPARK) return RxMaterial(vec3(1.0, 0.36, 0.08), 1.0, 0.0, 1.8, 0.0);
    return rx_material_properties(material);
}
#else
#define matter rx_material_properties
#endif
