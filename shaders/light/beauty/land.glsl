// The kinds of land around a finite world.
#ifndef BEAUTY_LAND_GLSL
#define BEAUTY_LAND_GLSL

const uint LAND_NONE = 0u, LAND_GROUND = 1u, LAND_SEA = 2u;
const vec3 LAND_SEA_ALBEDO = vec3(0.06, 0.20, 0.26);   // of water that nothing is seen through
const vec3 LAND_PLAIN_ALBEDO = vec3(0.42, 0.38, 0.30);  // around a world that shows no land at its border

#endif
