// Light that air and mist add in each slice, and what they let through: sixteen steps a slice, each with its own rays to the
// sun and to the sky, and a transmittance for each colour. A thread for each slice: lavapipe ends a loop after 65,536 turns.
#version 460
#include <raxel/world.glsl>
#include "light/scene.glsl"
#include <raxel/light/atmosphere.glsl>
#include <raxel/random.glsl>

layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba32f) uniform writeonly image2D outSent;
layout(rgba32f) uniform writeonly image2D outClear;
uniform sampler2D scattered;
layout(push_constant) uniform Push { float metres; float mist; float mist_height; float mist_floor; } push;

const int STEPS = 16, SKY_RAYS = 8;

// The share of the directions above from which the sky is seen.
float open_above(RxRay at, uint first, uint seed) {
    float open = 0.0;
    for (int i = 0; i < SKY_RAYS; ++i) {
        vec2 sky = rx_sobol(first + uint(i), 1u, seed);
        float angle = 2.0 * RX_PI * sky.x, side = sqrt(1.0 - sky.y * sky.y);
        RxHit block;
        if (!rx_trace(rx_ray(at.cell, at.frac, vec3(side * cos(angle), sky.y + 1e-3, side * sin(angle))), block)) open += 1.0 / float(SKY_RAYS);
    }
    return open;
}

float depth(float share) {
    return 8.0 * (pow(2.0, 9.0 * share) - 1.0);
}

// Of one slice: the light that it sends, and what it lets through.
void main() {
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy), column = ivec2(texel.x % 40, texel.y);
    if (any(greaterThanEqual(texel, imageSize(outSent)))) return;
    int i = texel.x / 40;
    vec3 sun = frame_sun(), sunlight = sun_irradiance(sun);
    vec3 dir = rx_camera_direction(frame.view_to_world, frame.tan_half_fov, vec2(column) + 0.5, vec2(40.0, 24.0));
    float cosine = dot(dir, sun), km = 0.001 * push.metres;
    vec3 towards = normalize(vec3(sun.x, 0.15, sun.z) + vec3(1e-4, 0.0, 0.0));
    vec3 sky = 0.5 * (sky_radiance(vec3(0.0, 1.0, 0.0), sun) + sky_radiance(towards, sun));
    vec3 many = frame.sky_strength * RX_AIR_PI * textureLod(scattered, rx_scattered_place(RX_AIR_GROUND + RX_AIR_EYE, sun.y), 0.0).rgb;
    vec3 light = vec3(0.0), clear = vec3(1.0);
    float camera_height = float(frame.camera_cell.y) + frame.camera_frac.y;
    uint seed = rx_hash(uint(texel.x) + 4711u * uint(texel.y));
    float from = depth(float(i) / 32.0), length = (depth(float(i + 1) / 32.0) - from) / float(STEPS);
    for (int k = 0; k < STEPS; ++k) {
        float t = from + (float(k) + 0.5) * length, height = camera_height + t * dir.y;
        vec3 at = frame.camera_frac + t * dir;
        ivec3 cell = ivec3(floor(at));
        RxHit block;
        RxRay to_sun = rx_ray(frame.camera_cell + cell, at - vec3(cell), sun);
        bool lit = !rx_trace(to_sun, block);
        float above = open_above(to_sun, uint(k * SKY_RAYS), seed);
        RxAir air = rx_air(max(RX_AIR_EYE + 0.001 * (height - camera_height), 0.0));
        float thick = 0.001 * push.mist * exp(-max(height - push.mist_floor, 0.0) / push.mist_height);
        vec3 loss = air.extinction * km + thick, sent = above * ((air.rayleigh + air.mie) * km * many + 0.9 * thick * sky);
        if (lit) sent += sunlight * (air.rayleigh * km * rx_rayleigh_phase(cosine) + air.mie * km * rx_mie_phase(cosine, RX_AIR_MIE_G)
                                     + 0.9 * thick * rx_mie_phase(cosine, 0.6));
        vec3 through = exp(-loss * length);
        light += clear * sent * (1.0 - through) / loss;
        clear *= through;
    }
    imageStore(outSent, texel, vec4(light, 0.0));
    imageStore(outClear, texel, vec4(clear, 0.0));
}
