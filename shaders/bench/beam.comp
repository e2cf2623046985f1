// A beam for each tile of TILE x TILE pixels, which goes on from that of the tile of COARSE x COARSE pixels around it.
#version 460
#include <raxel/world.glsl>
#include <raxel/beam.glsl>

// A beam that is not stopped after this many rounds goes along a surface; its rays may as well.
const int ROUNDS = 16;

layout(local_size_x = 8, local_size_y = 4) in;
layout(r32f) uniform writeonly image2D outBeams;  // free depth, voxels
#ifdef COARSE
layout(r32f) uniform readonly image2D coarse;
#endif

layout(push_constant) uniform Push {
    mat4 view_to_world;
    ivec3 camera_cell;
    vec3 camera_frac;
    vec2 tan_half_fov;
    ivec2 size;
} push;

void main() {
    ivec2 tile = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(tile, imageSize(outBeams)))) return;
    float depth = 0.0;
#ifdef COARSE
    ivec2 around = tile * TILE / COARSE;
    if (all(lessThan(around, imageSize(coarse)))) depth = imageLoad(coarse, around).x;
#endif
    ivec2 first = tile * TILE, last = min(first + TILE, push.size) - 1;
    if (depth < RX_BEAM_NOTHING) {
        depth = rx_beam(push.camera_cell, push.camera_frac, push.view_to_world, push.tan_half_fov, first, last, push.size, depth, ROUNDS);
    }
    imageStore(outBeams, tile, vec4(depth));
}
