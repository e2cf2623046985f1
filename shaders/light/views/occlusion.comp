// Openness of each pixel's first hit, by a guess and by rays.
#version 460
#include <raxel/world.glsl>
#include <raxel/shade.glsl>
#include "../scene.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(rg32f) uniform image2D open;
layout(rgba32f) uniform writeonly image2D outRadiance;
layout(push_constant) uniform Push { float reach; float split; } push;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), size = imageSize(open);
    if (any(greaterThanEqual(pixel, size))) return;
    RxRay ray = rx_ray(frame.camera_cell, frame.camera_frac, pixel_direction(pixel, size));
    bool by_rays = float(pixel.x) >= push.split * float(size.x);
    float share = 1.0;
    vec2 sum = frame.still > 0u ? imageLoad(open, pixel).xy : vec2(0.0);
    RxHit hit;
    for (int turn = 0; turn < 2; ++turn) {
        RxHit next;
        bool found = rx_trace(ray, next);
        if (turn == 1) {
            sum += vec2(found ? 0.0 : 1.0, 1.0);
            share = sum.x / sum.y;
            break;
        }
        if (!found || next.face == RX_FACE_INSIDE) break;
        hit = next;
        share = rx_openness(hit);
        if (!by_rays) break;
        vec2 u = rx_sobol(frame.still, 0u, scene_seed(uint(pixel.x) + rx_hash(uint(pixel.y))));
        ray = rx_ray_from_face(hit.voxel, hit.face, hit.uv, rx_cosine_direction(hit.face, u));
        ray.t_max = push.reach;
    }
    imageStore(open, pixel, vec4(sum, 0.0, 0.0));
    imageStore(outRadiance, pixel, vec4(vec3(share), 1.0));
}
