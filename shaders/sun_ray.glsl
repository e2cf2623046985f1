// Rays to the sun from what the pixels see, for sun_tiles.comp and sun_rest.comp.
#include <raxel/camera.glsl>
#include <raxel/sky.glsl>

layout(rgba32i) uniform readonly iimage2D firstHits;  // what the pixels' own rays hit: voxel, face; w = -1 for the sky
layout(r8ui) uniform writeonly uimage2D outSun;       // 1 where the sun is seen, 0 where it is hidden and where no ray goes to it

layout(push_constant) uniform Push {
    mat4 view_to_world;
    ivec3 camera_cell;
    float sun_azimuth;
    vec3 camera_frac;
    float sun_elevation;
    vec2 tan_half_fov;
} push;

vec3 sun_direction() {
    return rx_sun_direction(push.sun_azimuth, push.sun_elevation);
}

// Whether a pixel's hit needs a ray to the sun. The sky, faces that look away from the sun, and hits inside a solid voxel need none.
bool goes_to_sun(ivec2 pixel, vec3 sun, out ivec4 first) {
    first = ivec4(0);
    if (any(greaterThanEqual(pixel, imageSize(outSun)))) return false;
    first = imageLoad(firstHits, pixel);
    return first.w >= 0 && uint(first.w) != RX_FACE_INSIDE && dot(rx_normal(uint(first.w)), sun) > 0.0;
}

// That ray.
bool sun_ray(ivec2 pixel, vec3 sun, out RxRay ray) {
    ivec4 first;
    if (!goes_to_sun(pixel, sun, first)) return false;
    RxRay own = rx_camera_ray(push.camera_cell, push.camera_frac, push.view_to_world, push.tan_half_fov, pixel, imageSize(outSun));
    RxHit hit;
    rx_walk_known_hit(own, world.origin, world.log2_size, first.xyz, uint(first.w), hit);
    ray = rx_ray_from_face(hit.voxel, hit.face, hit.uv, sun);
    return true;
}
