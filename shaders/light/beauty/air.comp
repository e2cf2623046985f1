// Light that the air and the mist add before each depth, and what they let through: a column of slices for each part of the view. The
// slices grow with the distance. One ray a slice asks whether the sun reaches it, so that trees throw shafts into
// the mist, and panes of glass coloured ones.
#version 460
#include <raxel/world.glsl>
#include "../scene.glsl"
#include <raxel/light/atmosphere.glsl>
#include "air_slices.glsl"
#ifdef PANES
#include <raxel/light/body.glsl>
#endif

layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba16f) uniform writeonly image3D outAir;
uniform sampler2D scattered;
layout(push_constant) uniform Push { float metres; float mist; float mist_height; float mist_floor; } push;

void main() {
    ivec2 column = ivec2(gl_GlobalInvocationID.xy);
    ivec3 size = imageSize(outAir);
    if (any(greaterThanEqual(column, size.xy))) return;
    vec3 sun = frame_sun();
    vec3 dir = rx_camera_direction(frame.view_to_world, frame.tan_half_fov, vec2(column) + 0.5, vec2(size.xy));
    float cosine = dot(dir, sun), km = 0.001 * push.metres;
    vec3 sunlight = sun_irradiance(sun);
    // Skylight that mist scatters: the same from all sides.
    vec3 sky = 0.5 * (sky_radiance(vec3(0.0, 1.0, 0.0), sun) + sky_radiance(normalize(vec3(sun.x, 0.15, sun.z) + vec3(1e-4, 0.0, 0.0)), sun));
    float eye = RX_AIR_GROUND + RX_AIR_EYE, sun_cosine = sun.y;
    vec3 many = frame.sky_strength * RX_AIR_PI * textureLod(scattered, rx_scattered_place(eye, sun_cosine), 0.0).rgb;
    float rayleigh = rx_rayleigh_phase(cosine), mie = rx_mie_phase(cosine, RX_AIR_MIE_G), misty = rx_mie_phase(cosine, 0.6);
    uint seed = scene_seed(uint(column.x) + rx_hash(uint(column.y) + 4711u));
    vec3 light = vec3(0.0);
    vec3 clear = vec3(1.0);
    float camera_height = float(frame.camera_cell.y) + frame.camera_frac.y;
    for (int i = 0; i < size.z; ++i) {
        float near = slice_depth(float(i) / float(size.z)), far = slice_depth(float(i + 1) / float(size.z));
        float t = mix(near, far, rx_sobol(frame.index, 0u, rx_hash(seed + uint(i))).x), length = far - near;
        // The direct light, asked for once a slice.
        float height = camera_height + t * dir.y;
        vec3 lit = vec3(1.0), above = vec3(1.0);
        if (t < 600.0) {
            vec3 at = frame.camera_frac + t * dir;
            ivec3 cell = ivec3(floor(at));
            RxRay ray = rx_ray(frame.camera_cell + cell, at - vec3(cell), sun);
            RxHit block;
            bool blocked = sunlight != vec3(0.0) && rx_trace(ray, block);
#ifdef PANES
            for (int pane = 0; pane < 2 && blocked && rx_pass_body(block, PANES, ray, lit); ++pane) blocked = rx_trace(ray, block);
#endif
            if (blocked) lit = vec3(0.0);
#ifdef PANES
            // Indoors, little of the sky reaches the mist: one ray to anywhere above says how much.
            uint state = rx_hash(rx_hash(seed + uint(i)) ^ frame.index);
            vec3 up = rx_random_direction(state);
            up.y = abs(up.y) + 1e-3;
            vec3 open = vec3(1.0);
            ray = rx_ray(frame.camera_cell + cell, at - vec3(cell), up);
            blocked = rx_trace(ray, block);
            for (int pane = 0; pane < 2 && blocked && rx_pass_body(block, PANES, ray, open); ++pane) blocked = rx_trace(ray, block);
            above = blocked ? vec3(0.0) : open;
#endif
        }
        RxAir air = rx_air(max(RX_AIR_EYE + 0.001 * (height - camera_height), 0.0));
        float thick = 0.001 * push.mist * exp(-max(height - push.mist_floor, 0.0) / push.mist_height);
        vec3 loss = air.extinction * km + thick;
        vec3 sent = sunlight * lit * (air.rayleigh * km * rayleigh + air.mie * km * mie + 0.9 * thick * misty)
                  + above * (many * (air.rayleigh + air.mie) * km + 0.9 * thick * sky);
        vec3 through = exp(-loss * length);
        light += clear * sent * (1.0 - through) / max(loss, vec3(1e-9));
        clear *= through;
        // What lies behind is seen through gray air: there is one number for that.
        imageStore(outAir, ivec3(column, i), vec4(light, dot(clear, vec3(1.0 / 3.0))));
    }
}
