// The clouds before the sky, at half the picture's width and height: a march, whose places are others in each frame.
#version 460
#include "../scene.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba16f) uniform writeonly image2D outClouds;   // light, and the share that comes through

const int STEPS = 14;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), size = imageSize(outClouds);
    if (any(greaterThanEqual(pixel, size)) || sky_clouds.x <= 0.0) return;
    vec3 dir = rx_camera_direction(frame.view_to_world, frame.tan_half_fov, vec2(pixel) + 0.5, vec2(size));
    float shift = fract(noise_value(rx_hash(ivec3(pixel, 0))) + 0.6180339887 * float(frame.index & 1023u));
    imageStore(outClouds, pixel, cloud_march(vec3(frame.camera_cell) + frame.camera_frac, dir, frame_sun(), STEPS, shift));
}
