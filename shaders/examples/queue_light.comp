// One thread for each queued pixel: albedo, sun and its shadow.
#version 460
#include <raxel/world.glsl>
#include <raxel/shade.glsl>
#include <raxel/thread.glsl>

layout(local_size_x = 64) in;
layout(std430) readonly buffer Count { uint count; };
layout(std430) readonly buffer Pixels { uint pixels[]; };
layout(rgba32i) uniform readonly iimage2D hits;
layout(rg32f) uniform readonly image2D places;
// Not `writeonly`: the sky between the queued pixels stays.
layout(rgba16f) uniform image2D color;

layout(push_constant) uniform Push {
    float sun_azimuth;
} push;

void main() {
    uint thread = rx_thread();
    // More may have been counted than the queue has room for.
    if (thread >= min(count, uint(pixels.length()))) return;
    uint at = pixels[thread];
    uint width = uint(imageSize(color).x);
    ivec2 pixel = ivec2(at % width, at / width);
    ivec4 found = imageLoad(hits, pixel);
    uint face = uint(found.w) & 7u;
    vec3 albedo = rx_material_properties(uint(found.w) >> 3).albedo;
    vec3 sun = rx_sun_direction(push.sun_azimuth, 32.0);
    float light = 0.3;
    float facing = face == RX_FACE_INSIDE ? 0.0 : dot(rx_normal(face), sun);
    if (facing > 0.0) {
        RxHit shadow;
        RxRay ray = rx_ray_from_face(found.xyz, face, imageLoad(places, pixel).xy, sun);
        if (!rx_trace(ray, shadow)) light += facing;
    }
    vec4 before = imageLoad(color, pixel);
    imageStore(color, pixel, vec4(albedo * light, before.a));
}
