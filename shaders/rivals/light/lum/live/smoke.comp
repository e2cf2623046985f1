// Smoke along a ray, from its entry into the smoke's column to its exit or to a surface: 16 steps of four octaves of noise that drift with the
// wind. The radiance field lights the smoke once, where the ray leaves (as in Lum).
#version 460
#include <raxel/ray.glsl>
#include "light/scene.glsl"
#include "../field.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba32i) uniform readonly iimage2D hits;
layout(rgba32f) uniform readonly image2D places;
uniform sampler3D probes;
uniform sampler3D noise;
layout(rgba32f) uniform image2D radiance;
layout(push_constant) uniform Push { vec3 fire; float time; float smoke; } push;

const float TALL = 26.0;     // of the column, voxels
const float WIDE = 5.5;      // half its width at its widest
const int STEPS = 16;

// The part of a ray that lies in an upright ellipsoid around the column.
bool column(vec3 from, vec3 dir, out float near, out float far) {
    vec3 radii = vec3(WIDE, 0.5 * TALL, WIDE), o = (from - vec3(0.0, 0.5 * TALL, 0.0)) / radii, d = dir / radii;
    float a = dot(d, d), b = dot(o, d), c = dot(o, o) - 1.0, q = b * b - a * c;
    if (q <= 0.0) return false;
    near = max((-b - sqrt(q)) / a, 0.0);
    far = (-b + sqrt(q)) / a;
    return far > near;
}

float thickness(vec3 at) {
    vec3 drift = vec3(0.05, -0.35, 0.02) * push.time;
    float sum = 0.0, strength = 0.5, size = 1.0 / 22.0;
    for (int i = 0; i < 4; ++i) {
        sum += strength * textureLod(noise, at * size + drift, 0.0).x;
        strength *= 0.5;
        size *= 2.1;
        drift *= 1.3;
    }
    float height = at.y / TALL, out_there = length(at.xz) / (WIDE * (0.35 + 0.65 * sqrt(clamp(height, 0.0, 1.0))));
    return max(sum - 0.30 - 0.35 * out_there, 0.0) * (1.0 - smoothstep(0.5, 1.0, height)) * smoothstep(0.0, 0.08, height);
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), size = imageSize(radiance);
    if (any(greaterThanEqual(pixel, size))) return;
    vec3 dir = pixel_direction(pixel, size);
    vec3 from = vec3(frame.camera_cell) + frame.camera_frac - push.fire;
    float near, far;
    if (!column(from, dir, near, far)) return;
    if (imageLoad(hits, pixel).w >= 0) far = min(far, imageLoad(places, pixel).z);
    if (far <= near) return;
    float step = (far - near) / float(STEPS), clear = 1.0;
    // Half a step at random hides the layers.
    uint seed = scene_seed(uint(pixel.x) + rx_hash(uint(pixel.y) + 91u));
    float start = rx_random(seed);
    for (int i = 0; i < STEPS; ++i) clear *= exp(-push.smoke * step * thickness(from + (near + (float(i) + start) * step) * dir));
    vec3 place = from + far * dir + push.fire - vec3(grid.world_min);
    // The field has no directions; half of it comes from where the eye cannot see it.
    vec3 light = 0.8 * field(probes, place, dir, 0.0) + 0.08 * sun_irradiance(frame_sun());
    imageStore(radiance, pixel, vec4(mix(light, imageLoad(radiance, pixel).rgb, clear), 1.0));
}
