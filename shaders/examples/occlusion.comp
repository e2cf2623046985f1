// Estimates by one random ray how open each visible point is. atrous.comp removes the noise.
#version 460
#include <raxel/world.glsl>
#include <raxel/camera.glsl>
#include <raxel/random.glsl>
#include "frame.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba8_snorm) uniform writeonly image2D outNormal;
layout(r32f) uniform writeonly image2D outDepth;   // voxels; 0 for the sky
layout(rgba16f) uniform writeonly image2D outOpen;
layout(push_constant) uniform Push {
    float reach;  // voxels
} push;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    ivec2 size = imageSize(outOpen);
    if (any(greaterThanEqual(pixel, size))) return;

    RxRay ray = rx_camera_ray(frame.camera_cell, frame.camera_frac, frame.view_to_world, frame.tan_half_fov, pixel, size);
    RxHit hit, seen;
    float open = 1.0;
    bool found = false;
    // The two rays take turns in one loop: the tracer is compiled once.
    for (int turn = 0; turn < 2; ++turn) {
        bool solid = rx_trace(ray, hit);
        if (turn == 1) {
            open = solid ? min(hit.t / push.reach, 1.0) : 1.0;
            break;
        }
        seen = hit;
        found = solid && hit.face != RX_FACE_INSIDE;
        if (!found) break;
        uint state = rx_hash(ivec3(pixel, 7));
        // Cosine-weighted around the normal.
        vec3 dir = normalize(rx_normal(hit.face) + 0.999 * rx_random_direction(state));
        ray = rx_ray_from_face(hit.voxel, hit.face, hit.uv, dir);
        ray.t_max = push.reach;
    }
    imageStore(outNormal, pixel, vec4(found ? rx_normal(seen.face) : vec3(0.0), 0.0));
    imageStore(outDepth, pixel, vec4(found ? seen.t : 0.0));
    imageStore(outOpen, pixel, vec4(vec3(open), 1.0));
}
