// Light of the sky on the first voxel along each pixel's ray, by one more ray in a random direction around the normal. The camera
// should stand still: the light of the last frame is taken from the same pixel.
#version 460
#include <raxel/world.glsl>
#include <raxel/camera.glsl>
#include <raxel/shade.glsl>
#include <raxel/random.glsl>

layout(local_size_x = 8, local_size_y = 8) in;
layout(r32f) uniform readonly image2D before;
layout(r32f) uniform writeonly image2D outLight;
layout(rgba16f) uniform writeonly image2D outColor;
uniform sampler3D noise;  // x, y, time

layout(push_constant) uniform Push {
    mat4 view_to_world;
    ivec3 camera_cell;
    uint frame;
    vec3 camera_frac;
    float split;
    vec2 tan_half_fov;
    float keep;
} push;

// Two numbers in 0 to 1. The second is the same noise, shifted by half its size.
vec2 blue(ivec2 pixel) {
    ivec3 size = textureSize(noise, 0);
    ivec3 at = ivec3(pixel, int(push.frame)) % size;
    ivec3 other = ivec3(pixel + size.xy / 2, int(push.frame) + size.z / 2) % size;
    // The centre of each of the 256 steps.
    return vec2(texelFetch(noise, at, 0).r, texelFetch(noise, other, 0).r) * (255.0 / 256.0) + 0.5 / 256.0;
}

vec2 white(ivec2 pixel) {
    uint state = rx_hash(uint(pixel.x) + rx_hash(uint(pixel.y) + rx_hash(push.frame)));
    return vec2(rx_random(state), rx_random(state));
}

// A direction around a normal, with the cosine as its density.
vec3 around(vec3 normal, vec2 u) {
    float turn = 6.2831853 * u.x, radius = sqrt(u.y);
    vec3 side = abs(normal.y) > 0.5 ? vec3(1.0, 0.0, 0.0) : vec3(0.0, 1.0, 0.0);
    return normalize(radius * (cos(turn) * side + sin(turn) * cross(normal, side)) + sqrt(1.0 - u.y) * normal);
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    ivec2 size = imageSize(outColor);
    if (any(greaterThanEqual(pixel, size))) return;

    vec3 sun = rx_sun_direction(215.0, 40.0);
    RxRay ray = rx_camera_ray(push.camera_cell, push.camera_frac, push.view_to_world, push.tan_half_fov, pixel, size);
    RxHit hit;
    vec3 color = rx_sky(ray.dir, sun);
    float light = 0.0;
    if (rx_trace(ray, hit) && hit.face != RX_FACE_INSIDE) {
        vec2 u = float(pixel.x) < push.split * float(size.x) ? blue(pixel) : white(pixel);
        RxHit blocker;
        light = rx_trace(rx_ray_from_face(hit.voxel, hit.face, hit.uv, around(rx_normal(hit.face), u)), blocker) ? 0.0 : 1.0;
        if (push.frame > 0u) light = mix(light, imageLoad(before, pixel).r, push.keep);
        color = rx_material_properties(hit.material).albedo * light;
    }
    imageStore(outLight, pixel, vec4(light));
    imageStore(outColor, pixel, vec4(rx_tone_curve(color), 1.0));
}
