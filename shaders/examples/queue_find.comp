// Draws the sky, and queues every pixel that sees something else.
#version 460
#include <raxel/world.glsl>
#include <raxel/camera.glsl>

layout(local_size_x = 8, local_size_y = 8) in;
layout(std430) buffer Count { uint count; uint lost; };
layout(std430) writeonly buffer Pixels { uint pixels[]; };
layout(rgba32i) uniform writeonly iimage2D outHit;
layout(rg32f) uniform writeonly image2D outPlace;
layout(rgba16f) uniform writeonly image2D outColor;

layout(push_constant) uniform Push {
    mat4 view_to_world;
    ivec3 camera_cell;
    vec3 camera_frac;
    vec2 tan_half_fov;
} push;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    ivec2 size = imageSize(outColor);
    if (any(greaterThanEqual(pixel, size))) return;
    RxRay ray = rx_camera_ray(push.camera_cell, push.camera_frac, push.view_to_world, push.tan_half_fov, pixel, size);
    RxHit hit;
    bool found = rx_trace(ray, hit);
    imageStore(outColor, pixel, vec4(0.45, 0.65, 0.9, 1.0));
    imageStore(outHit, pixel, found ? ivec4(hit.voxel, int(hit.material << 3 | hit.face)) : ivec4(0));
    imageStore(outPlace, pixel, found ? vec4(hit.uv, 0.0, 0.0) : vec4(0.0));
    if (!found) return;
    // `lost` costs nothing while the queue has room, and this one has room for every pixel of the picture.
    uint at = atomicAdd(count, 1u);
    if (at < pixels.length()) pixels[at] = uint(pixel.y * size.x + pixel.x);
    else atomicAdd(lost, 1u);
}
