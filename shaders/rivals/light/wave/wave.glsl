// Buffers of paths, their hits and their requests.
#include <raxel/ray.glsl>

struct Path {
    ivec3 cell;
    uint pixel;
    vec3 frac;
    float density;  // the density with which the direction was drawn, per steradian; 0 from the camera
    vec3 dir;
    uint bin;
    vec3 share;     // of the light from there that reaches the eye
    uint unused;
};

struct PathHit {
    ivec4 at;       // voxel; material and face, -1 for the sky
    vec4 place;     // place on the face, distance
};

// Two rays from one place: to the sun, and to a lamp. `sunlight` and `lamplight` count if nothing blocks the ray.
struct Ask {
    ivec3 cell;
    uint pixel;
    vec3 frac;
    float unused0;
    vec3 to_sun;
    float unused1;
    vec3 sunlight;
    float unused2;
    vec3 to_lamp;
    float unused3;
    vec3 lamplight;
    float unused4;
};

const uint WAVE_BINS = 512u;

// The octant of a direction, and columns of 32 x 32 voxels.
uint wave_bin(ivec3 cell, ivec3 world_min, vec3 dir) {
    uvec3 c = uvec3(cell - world_min) >> 5;
    return (dir.x < 0.0 ? 1u : 0u) | (dir.y < 0.0 ? 2u : 0u) | (dir.z < 0.0 ? 4u : 0u) | (c.x & 7u) << 3 | (c.z & 7u) << 6;
}
