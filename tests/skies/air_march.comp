// Light that air and mist add before the end of each slice, and what they let through: sixteen steps a slice, each with its own ray to the
// sun, and a transmittance for each colour.
#version 460
#include <raxel/world.glsl>
#include "light/scene.glsl"
#include <raxel/light/atmosphere.glsl>

layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba32f) uniform writeonly image2D outMarched;
uniform sampler2D scattered;
layout(push_constant) uniform Push { float metres; float mist; float mist_height; float mist_floor; } push;

const int STEPS = 16;

float depth(float share) {
    return 8.0 * (pow(2.0, 9.0 * share) - 1.0);
}

void main() {
    ivec2 column = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(column, ivec2(40, 24)))) return;
    vec3 sun = frame_sun(), sunlight = sun_irradiance(sun);
    vec3 dir = rx_camera_direction(frame.view_to_world, frame.tan_half_fov, vec2(column) + 0.5, vec2(40.0, 24.0));
    float cosine = dot(dir, sun), km = 0.001 * push.metres;
    vec3 towards = normalize(vec3(sun.x, 0.15, sun.z) + vec3(1e-4, 0.0, 0.0));
    vec3 sky = 0.5 * (sky_radiance(vec3(0.0, 1.0, 0.0), sun) + sky_radiance(towards, sun));
    vec3 many = frame.sky_strength * RX_AIR_PI * textureLod(scattered, rx_scattered_place(RX_AIR_GROUND + RX_AIR_EYE, sun.y), 0.0).rgb;
    vec3 light = vec3(0.0), clear = vec3(1.0);
    float camera_height = float(frame.camera_cell.y) + frame.camera_frac.y;
    for (int i = 0; i < 32; ++i) {
        float from = depth(float(i) / 32.0), length = (depth(float(i + 1) / 32.0) - from) / float(STEPS);
        for (int k = 0; k < STEPS; ++k) {
            float t = from + (float(k) + 0.5) * length, height = camera_height + t * dir.y;
            vec3 at = frame.camera_frac + t * dir;
            ivec3 cell = ivec3(floor(at));
            RxHit block;
            bool lit = !rx_trace(rx_ray(frame.camera_cell + cell, at - vec3(cell), sun), block);
            RxAir air = rx_air(max(RX_AIR_EYE + 0.001 * (height - camera_height), 0.0));
            float thick = 0.001 * push.mist * exp(-max(height - push.mist_floor, 0.0) / push.mist_height);
            vec3 loss = air.extinction * km + thick, sent = (air.rayleigh + air.mie) * km * many + 0.9 * thick * sky;
            if (lit) sent += sunlight * (air.rayleigh * km * rx_rayleigh_phase(cosine) + air.mie * km * rx_mie_phase(cosine, RX_AIR_MIE_G)
                                         + 0.9 * thick * rx_mie_phase(cosine, 0.6));
            light += clear * sent * length;
            clear *= exp(-loss * length);
        }
        imageStore(outMarched, ivec2(i * 40 + column.x, column.y), vec4(light, dot(clear, vec3(1.0 / 3.0))));
    }
}
