// Rays, hits, faces and materials: the vocabulary of the tracing contract. Nothing here knows how a world is stored.
#ifndef RAXEL_RAY_GLSL
#define RAXEL_RAY_GLSL

// A ray starts in the closed cube of `cell` (a component of `frac` may be 1: a start on the far face, still in this cell).
// Its length is free: a hit lies at origin + t * dir. Hits beyond t_max are misses.
// The tracer puts `frac` on multiples of 2^-24 and `dir` on 31 bits below the exponent of its largest component, and is exact for
// that lattice ray. A NaN, an infinity or a zero direction hits nothing.
struct RxRay {
    ivec3 cell;
    vec3 frac;
    vec3 dir;
    float t_max;
};

// The hit of a ray.
struct RxHit {
    ivec3 voxel;
    uint face;      // the face of the voxel that was hit: RX_FACE_*
    uint material;  // index for rx_material_properties; 0 is air
    float t;        // in lengths of ray.dir
    vec2 uv;        // place on the face, 0 to 1, along the two other axes in the order x, y, z
    uint steps;     // cells that were looked at
};

// The material of a voxel.
struct RxMaterial {
    vec3 albedo;         // linear reflectance
    float roughness;     // 0 mirror, 1 matt
    float metallic;      // 0 dielectric, 1 metal
    float emission;      // in multiples of albedo
    float transparency;  // 0 opaque, 1 clear
};

const uint RX_FACE_NEG_X = 0u;
const uint RX_FACE_POS_X = 1u;
const uint RX_FACE_NEG_Y = 2u;
const uint RX_FACE_POS_Y = 3u;
const uint RX_FACE_NEG_Z = 4u;
const uint RX_FACE_POS_Z = 5u;
const uint RX_FACE_INSIDE = 6u;  // the ray started in a solid voxel

const float RX_FAR = 3.0e38;

// A ray without an end.
RxRay rx_ray(ivec3 cell, vec3 frac, vec3 dir) {
    return RxRay(cell, frac, dir, RX_FAR);
}

// 0, 1 or 2; 3 for RX_FACE_INSIDE.
uint rx_face_axis(uint face) {
    return face >> 1;
}

// Whether a difference of cells is more than `reach` on an axis. No int holds the size of -2^31, so abs would give a wrong answer.
bool rx_beyond(ivec3 difference, int reach) {
    return any(greaterThan(uvec3(difference + reach), uvec3(2 * reach)));
}

// Whether the difference of two cells overflows 32 bits. They are then near different ends of the coordinates, and a
// wrapped difference would make them neighbours.
bool rx_wraps(ivec3 a, ivec3 b) {
    ivec3 over = (a ^ b) & (a ^ (a - b));
    return (over.x | over.y | over.z) < 0;
}

// The step from a voxel to its neighbour across a face: the outward normal. Zero for RX_FACE_INSIDE.
ivec3 rx_face_step(uint face) {
    int side = (face & 1u) != 0u ? 1 : -1;
    uint axis = rx_face_axis(face);
    return ivec3(axis == 0u ? side : 0, axis == 1u ? side : 0, axis == 2u ? side : 0);
}

// The outward normal of a face; zero for RX_FACE_INSIDE.
vec3 rx_normal(uint face) {
    return vec3(rx_face_step(face));
}

// The unit steps along which hit.uv runs on a face.
void rx_face_tangents(uint face, out ivec3 u, out ivec3 v) {
    uint axis = rx_face_axis(face);
    u = axis == 0u ? ivec3(0, 1, 0) : ivec3(1, 0, 0);
    v = axis == 2u ? ivec3(0, 1, 0) : ivec3(0, 0, 1);
}

// A ray that leaves a face: it starts in the neighbour's cube, exactly on the shared plane, so no epsilon is needed.
RxRay rx_ray_from_face(ivec3 voxel, uint face, vec2 uv, vec3 dir) {
    uint axis = rx_face_axis(face);
    float plane = (face & 1u) != 0u ? 0.0 : 1.0;
    vec3 frac = axis == 0u ? vec3(plane, uv) : axis == 1u ? vec3(uv.x, plane, uv.y) : vec3(uv, plane);
    return rx_ray(voxel + rx_face_step(face), frac, dir);
}

// A ray that goes on from a hit, for any face.
RxRay rx_ray_from_hit(RxHit hit, vec3 dir) {
    return hit.face == RX_FACE_INSIDE ? rx_ray(hit.voxel, vec3(hit.uv, 0.5), dir)
                                      : rx_ray_from_face(hit.voxel, hit.face, hit.uv, dir);
}

#endif
