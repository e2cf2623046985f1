// Traces each pixel's ray to its first hit. This shader measures and judges tracers and layouts.
//
// A define of <raxel/rivals/march.glsl> chooses how; without one, the exact tracer finds the hit.
#version 460
#include <raxel/world.glsl>
#include <raxel/rivals/march.glsl>
#include <raxel/camera.glsl>

layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba32i) uniform writeonly iimage2D outHit;  // voxel; face + 8 * material, or -1 where nothing is hit
layout(r32f) uniform writeonly image2D outDepth;    // in lengths of the ray's direction
layout(r32ui) uniform writeonly uimage2D outSteps;  // cells looked at

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
    bool found = rx_march(ray, hit);
    imageStore(outHit, pixel, found ? ivec4(hit.voxel, hit.face + 8u * hit.material) : ivec4(0, 0, 0, -1));
    imageStore(outDepth, pixel, vec4(found ? hit.t : 0.0));
    imageStore(outSteps, pixel, uvec4(hit.steps));
}
