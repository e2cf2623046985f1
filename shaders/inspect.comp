// Writes the first hit of each pixel: a target for each of its values.
#version 460
#include <raxel/scene.glsl>
#include <raxel/camera.glsl>

layout(local_size_x = 8, local_size_y = 8) in;
layout(rg32ui) uniform writeonly uimage2D outHit;        // material, face; (0, 7) where nothing was hit
layout(r32f) uniform writeonly image2D outDepth;         // distance along the ray in voxels
layout(rgba8_snorm) uniform writeonly image2D outNormal;
layout(r32ui) uniform writeonly uimage2D outSteps;       // cells looked at

layout(push_constant) uniform Push {
    mat4 view_to_world;
    ivec3 camera_cell;
    float sky_depth;
    vec3 camera_frac;
    vec2 tan_half_fov;
} push;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    ivec2 size = imageSize(outHit);
    if (any(greaterThanEqual(pixel, size))) return;

    RxRay ray = rx_camera_ray(push.camera_cell, push.camera_frac, push.view_to_world, push.tan_half_fov, pixel, size);
    RxHit hit;
    bool found = rx_trace_places(rx_scene_ray(ray), hit);
    imageStore(outHit, pixel, uvec4(found ? uvec2(hit.material, RX_FACE_PART(hit.face)) : uvec2(0u, 7u), 0u, 0u));
    imageStore(outDepth, pixel, vec4(found ? hit.t : push.sky_depth));
    imageStore(outNormal, pixel, vec4(found ? rx_place_normal(hit.voxel, hit.face) : vec3(0.0), 0.0));
    imageStore(outSteps, pixel, uvec4(hit.steps));
}
