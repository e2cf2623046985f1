// Light on the surfaces of see.comp, and the part of it that is too bright to show: the finest mip of the glow.
#version 460
#include <raxel/sky.glsl>
#include <raxel/camera.glsl>
#include "frame.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba8) uniform readonly image2D albedos;
layout(rgba8_snorm) uniform readonly image2D normals;
layout(rgba16f) uniform writeonly image2D outLight;
layout(rgba16f) uniform writeonly image2D outGlow;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    ivec2 size = imageSize(outLight);
    if (any(greaterThanEqual(pixel, size))) return;

    vec3 sun = rx_sun_direction(frame.sun_azimuth, frame.sun_elevation);
    vec3 dir = rx_camera_direction(frame.view_to_world, frame.tan_half_fov, vec2(pixel) + 0.5, vec2(size));
    vec4 albedo = imageLoad(albedos, pixel);
    vec3 normal = imageLoad(normals, pixel).xyz;
    vec3 light = 2.5 * max(dot(normal, sun), 0.0) * rx_sun_color(sun) + 0.5 * rx_sky(vec3(0.0, 1.0, 0.0), sun);
    light = frame.exposure * (albedo.a > 0.5 ? albedo.rgb * light : rx_sky(dir, sun));
    imageStore(outLight, pixel, vec4(light, 1.0));
    imageStore(outGlow, pixel, vec4(max(light - 0.5, 0.0), 1.0));
}
