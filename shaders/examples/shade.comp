// Light on the surfaces of see.comp: the sun without shadows, the sky, and haze.
#version 460
#include <raxel/sky.glsl>
#include <raxel/camera.glsl>
#include "frame.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba8) uniform readonly image2D albedos;
layout(rgba8_snorm) uniform readonly image2D normals;
layout(r32f) uniform readonly image2D depths;
layout(rgba16f) uniform writeonly image2D outColor;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    ivec2 size = imageSize(outColor);
    if (any(greaterThanEqual(pixel, size))) return;

    vec3 sun = rx_sun_direction(frame.sun_azimuth, frame.sun_elevation);
    vec3 dir = rx_camera_direction(frame.view_to_world, frame.tan_half_fov, vec2(pixel) + 0.5, vec2(size));
    vec3 sky = rx_sky(dir, sun);
    vec4 albedo = imageLoad(albedos, pixel);
    vec3 normal = imageLoad(normals, pixel).xyz;
    vec3 light = 2.0 * max(dot(normal, sun), 0.0) * rx_sun_color(sun) + (0.7 + 0.3 * normal.y) * rx_sky(vec3(0.0, 1.0, 0.0), sun);
    vec3 surface = mix(sky, albedo.rgb * light, exp(-0.0008 * imageLoad(depths, pixel).x));
    imageStore(outColor, pixel, vec4(frame.exposure * (albedo.a > 0.5 ? surface : sky), 1.0));
}
