// The first of two passes. A thread for each 2 x 2 pixels finds how far their four rays are free together, and traces the top left ray
// from there. halfres_rest.comp traces the others.
#version 460
#include <raxel/world.glsl>
#include <raxel/rivals/march/bundle.glsl>
#include <raxel/camera.glsl>

layout(local_size_x = 8, local_size_y = 8) in;
layout(r32f) uniform writeonly image2D outFree;     // how far the four rays get along their steepest axis, voxels
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
    ivec2 tile = ivec2(gl_GlobalInvocationID.xy);
    ivec2 pixel = 2 * tile, size = imageSize(outHit);
    if (any(greaterThanEqual(pixel, size))) return;

    RxRay rays[RX_BUNDLE_RAYS];
    for (int i = 0; i < 4; ++i) {
        rays[i] = rx_camera_ray(push.camera_cell, push.camera_frac, push.view_to_world, push.tan_half_fov,
                                pixel + ivec2(i & 1, i >> 1), size);
    }
    uint looks;
    float free = rx_bundle_free(rays, looks);
    imageStore(outFree, tile, vec4(free));
    RxHit hit = RX_NO_HIT;
    bool found = free < RX_BUNDLE_EMPTY && rx_trace_from(rays[0], rx_bundle_time(rays[0], free), hit);
    imageStore(outHit, pixel, found ? ivec4(hit.voxel, hit.face + 8u * hit.material) : ivec4(0, 0, 0, -1));
    imageStore(outDepth, pixel, vec4(found ? hit.t : 0.0));
    imageStore(outSteps, pixel, uvec4(hit.steps + looks));
}
