// The second of two passes: the three pixels of four that halfres_tiles.comp has left, each from where it has found nothing before.
#version 460
#include <raxel/world.glsl>
#include <raxel/rivals/march/bundle.glsl>
#include <raxel/camera.glsl>

layout(local_size_x = 8, local_size_y = 8) in;
layout(r32f) uniform readonly image2D freeOfTile;   // what halfres_tiles.comp has found
layout(rgba32i) uniform writeonly iimage2D outHit;  // as in first_hit.comp
layout(r32f) uniform writeonly image2D outDepth;
layout(r32ui) uniform writeonly uimage2D outSteps;

layout(push_constant) uniform Push {
    mat4 view_to_world;
    ivec3 camera_cell;
    vec3 camera_frac;
    vec2 tan_half_fov;
} push;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    ivec2 size = imageSize(outHit);
    if (any(greaterThanEqual(pixel, size)) || ((pixel.x | pixel.y) & 1) == 0) return;

    RxRay ray = rx_camera_ray(push.camera_cell, push.camera_frac, push.view_to_world, push.tan_half_fov, pixel, size);
    float free = imageLoad(freeOfTile, pixel >> 1).x;
    RxHit hit = RX_NO_HIT;
    bool found = free < RX_BUNDLE_EMPTY && rx_trace_from(ray, rx_bundle_time(ray, free), hit);
    imageStore(outHit, pixel, found ? ivec4(hit.voxel, hit.face + 8u * hit.material) : ivec4(0, 0, 0, -1));
    imageStore(outDepth, pixel, vec4(found ? hit.t : 0.0));
    imageStore(outSteps, pixel, uvec4(hit.steps));
}
