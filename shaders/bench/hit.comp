// Traces each pixel's ray to its first hit. With TILE, the ray begins where the beam of its tile ended.
#version 460
#include <raxel/world.glsl>
#include <raxel/camera.glsl>
#ifdef TILE
#include <raxel/beam.glsl>
#endif

layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba32i) uniform writeonly iimage2D outHit;  // voxel; face, or -1 where nothing is hit
#ifdef TILE
layout(r32f) uniform readonly image2D beams;
#endif

layout(push_constant) uniform Push {
    mat4 view_to_world;
    ivec3 camera_cell;
    vec3 camera_frac;
    vec2 tan_half_fov;
} push;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    ivec2 size = imageSize(outHit);
    if (any(greaterThanEqual(pixel, size))) return;

    RxRay ray = rx_camera_ray(push.camera_cell, push.camera_frac, push.view_to_world, push.tan_half_fov, pixel, size);
    RxHit hit;
#ifdef TILE
    // The image of the tiles is rounded, and may be one short of the last.
    ivec2 tile = pixel / TILE;
    float depth = all(lessThan(tile, imageSize(beams))) ? imageLoad(beams, tile).x : 0.0;
    float free = rx_beam_time(depth, push.view_to_world, push.tan_half_fov, pixel, size);
    bool found = depth < RX_BEAM_NOTHING && rx_trace_from(ray, free, hit);
#else
    bool found = rx_trace(ray, hit);
#endif
    imageStore(outHit, pixel, found ? ivec4(hit.voxel, hit.face) : ivec4(0, 0, 0, -1));
}
