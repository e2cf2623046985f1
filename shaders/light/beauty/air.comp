// Light that the air and the mist add before each depth, and what they let through: a column of slices for each part of the view. What
// air_light.comp has found throws shafts into the mist, and is kept for its next run.
#version 460
#include "../scene.glsl"
#include <raxel/light/atmosphere.glsl>
#include "air_slices.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
uniform sampler3D sunBySlice;
uniform sampler3D skyBySlice;
layout(rgba32f) uniform writeonly image3D outSun;
layout(rgba32f) uniform writeonly image3D outSky;
layout(rgba16f) uniform writeonly image3D outAir;
uniform sampler2D scattered;
layout(push_constant) uniform Push { float metres; float mist; float mist_height; float mist_floor; } push;

// The mean of the mist's density between two heights, 1 at its floor.
float mist_between(float a, float b) {
    float low = min(a, b) - push.mist_floor, high = max(a, b) - push.mist_floor;
    if (high - low < 0.01 * push.mist_height) return exp(-max(0.5 * (low + high), 0.0) / push.mist_height);
    float below = min(high, 0.0) - min(low, 0.0);
    float above = push.mist_height * (exp(-max(low, 0.0) / push.mist_height) - exp(-max(high, 0.0) / push.mist_height));
    return (below + above) / (high - low);
}

void main() {
    ivec2 column = ivec2(gl_GlobalInvocationID.xy);
    ivec3 size = imageSize(outAir);
    if (any(greaterThanEqual(column, size.xy))) return;
    vec3 sun = frame_sun();
    vec3 dir = rx_camera_direction(frame.view_to_world, frame.tan_half_fov, vec2(column) + 0.5, vec2(size.xy));
    float cosine = dot(dir, sun), km = 0.001 * push.metres;
    vec3 sunlight = sun_irradiance(sun);
    // Skylight that mist scatters: the same from all sides.
    vec3 true_sun = frame_true_sun(), sky = 0.5 * (sky_radiance(vec3(0.0, 1.0, 0.0), sun) + sky_radiance(normalize(vec3(true_sun.x, 0.15, true_sun.z) + vec3(1e-4, 0.0, 0.0)), sun));
    float eye = RX_AIR_GROUND + RX_AIR_EYE, sun_cosine = true_sun.y;
    vec3 many = frame.sky_strength * RX_AIR_PI * textureLod(scattered, rx_scattered_place(eye, sun_cosine), 0.0).rgb;
    float rayleigh = rx_rayleigh_phase(cosine), mie = rx_mie_phase(cosine, RX_AIR_MIE_G), misty = rx_mie_phase(cosine, 0.6);
    vec3 light = vec3(0.0);
    vec3 clear = vec3(1.0);
    vec3 eye_place = vec3(frame.camera_cell) + frame.camera_frac;
    float camera_height = eye_place.y;
    for (int i = 0; i < size.z; ++i) {
        ivec3 slice = ivec3(column, i);
        float from = slice_depth(float(i) / float(size.z)), to = slice_depth(float(i + 1) / float(size.z)), length = to - from;
        float height = camera_height + 0.5 * (from + to) * dir.y;
        vec4 of_sun = texelFetch(sunBySlice, slice, 0), of_sky = texelFetch(skyBySlice, slice, 0);
        imageStore(outSun, slice, of_sun);
        imageStore(outSky, slice, of_sky);
        vec3 lit = of_sun.rgb * sun_through_clouds(eye_place + 0.5 * (from + to) * dir), above = of_sky.rgb;
        RxAir air = rx_air(max(RX_AIR_EYE + 0.001 * (height - camera_height), 0.0));
        float thick = 0.001 * push.mist * mist_between(camera_height + from * dir.y, camera_height + to * dir.y);
        vec3 loss = air.extinction * km + thick;
        vec3 sent = sunlight * lit * (air.rayleigh * km * rayleigh + air.mie * km * mie + 0.9 * thick * misty)
                  + above * (many * (air.rayleigh + air.mie) * km + 0.9 * thick * sky);
        vec3 through = exp(-loss * length);
        light += clear * sent * (1.0 - through) / max(loss, vec3(1e-9));
        clear *= through;
        // What lies behind is seen through gray air: there is one number for that.
        imageStore(outAir, slice, vec4(light, dot(clear, vec3(1.0 / 3.0))));
    }
}
