// Light of lamps that each slice sends: sixteen steps a slice, at each a ray to a point of every lamp; and what it lets through.
#version 460
#include <raxel/world.glsl>
#include "light/frame.glsl"
#include <raxel/light/atmosphere.glsl>
#include <raxel/light/lamps.glsl>
#include <raxel/random.glsl>

layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba32f) uniform writeonly image2D outSent;
layout(rgba32f) uniform writeonly image2D outClear;
layout(push_constant) uniform Push { float metres; float mist; float mist_height; float mist_floor; } push;

const int STEPS = 16;

float depth(float share) {
    return 8.0 * (pow(2.0, 9.0 * share) - 1.0);
}

void main() {
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy), column = ivec2(texel.x % 40, texel.y);
    if (any(greaterThanEqual(texel, imageSize(outSent)))) return;
    int i = texel.x / 40;
    vec3 dir = rx_camera_direction(frame.view_to_world, frame.tan_half_fov, vec2(column) + 0.5, vec2(40.0, 24.0));
    vec3 light = vec3(0.0), clear = vec3(1.0);
    float camera_height = float(frame.camera_cell.y) + frame.camera_frac.y, km = 0.001 * push.metres;
    float from = depth(float(i) / 32.0), length_of_step = (depth(float(i + 1) / 32.0) - from) / float(STEPS);
    for (int k = 0; k < STEPS; ++k) {
        float t = from + (float(k) + 0.5) * length_of_step, height = camera_height + t * dir.y;
        vec3 at = frame.camera_frac + t * dir;
        ivec3 cell = ivec3(floor(at));
        vec3 sent = vec3(0.0);
        float thick = 0.001 * push.mist * exp(-max(height - push.mist_floor, 0.0) / push.mist_height);
        for (uint n = 0u; n < rx_lights_count(); ++n) {
            RxLight lamp = rx_light(n);
            vec3 to = rx_to_light(lamp, rx_sobol(uint(k), 0u, rx_hash(uint(texel.x) + 4711u * uint(texel.y)) + n), frame.camera_cell + cell, at - vec3(cell));
            float square = dot(to, to), facing = max(-dot(rx_normal(lamp.face), to), 0.0) / sqrt(square);
            RxHit block;
            if (facing == 0.0 || rx_trace(rx_lamp_ray(rx_ray(frame.camera_cell + cell, at - vec3(cell), to), to), block)) continue;
            RxMaterial material = rx_material_properties(lamp.material);
            // The mist is even where the test has its lamps.
            sent += material.albedo * (frame.lamp_strength * material.emission * lamp.edge * lamp.edge * facing / square * rx_mie_phase(dot(dir, normalize(to)), 0.6) * exp(-thick * sqrt(square)));
        }
        RxAir air = rx_air(max(RX_AIR_EYE + 0.001 * (height - camera_height), 0.0));
        vec3 loss = air.extinction * km + thick, through = exp(-loss * length_of_step);
        light += clear * 0.9 * thick * sent * (1.0 - through) / loss;
        clear *= through;
    }
    imageStore(outSent, texel, vec4(light, 0.0));
    imageStore(outClear, texel, vec4(clear, 0.0));
}
