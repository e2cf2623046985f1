#version 460
#include <raxel/random.glsl>
#include <raxel/camera.glsl>
#include <raxel/light/reproject.glsl>
layout(local_size_x = 1) in;
layout(std430) buffer Results { float results[]; };

void main() {
    uint seed = 5u;
    float off = 0.0, behind = 0.0;
    const vec2 size = vec2(1920.0, 1080.0), tan_half_fov = vec2(1.0264, 0.57735);
    for (int i = 0; i < 1000; ++i) {
        vec3 z = rx_random_direction(seed), x = normalize(cross(vec3(0.3, 0.9, 0.1), z)), y = cross(z, x);
        mat4 view_to_world = mat4(vec4(x, 0.0), vec4(y, 0.0), vec4(z, 0.0), vec4(0.0, 0.0, 0.0, 1.0));
        vec2 pixel = size * vec2(rx_random(seed), rx_random(seed)), at;
        vec3 way = exp2(14.0 * rx_random(seed)) * rx_camera_direction(view_to_world, tan_half_fov, pixel, size);
        mat3 back = transpose(mat3(view_to_world));
        bool on_picture = rx_reproject(way, back, tan_half_fov, size, at);
        // One at the very edge may fall off it.
        if (on_picture) off = max(off, max(abs(at.x - pixel.x), abs(at.y - pixel.y)));
        else if (all(greaterThan(pixel, vec2(0.01))) && all(lessThan(pixel, size - 0.01))) off = 1e9;
        if (rx_reproject(-way, back, tan_half_fov, size, at)) behind += 1.0;
    }
    results[0] = off;
    results[1] = behind;
}
