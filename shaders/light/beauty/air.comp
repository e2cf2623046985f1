// Sums the light that air and mist add before each depth, and the share that they let through. Each part of the view has a column of slices.
// The light of air_light.comp and air_lamps.comp throws shafts into the mist.
#version 460
#include "../scene.glsl"
#include <raxel/light/atmosphere.glsl>
#include "air_slices.glsl"
#include "air_mist.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
uniform sampler3D sunBySlice;
uniform sampler3D skyBySlice;
uniform sampler3D lampsBySlice;
layout(rgba16f) uniform writeonly image3D outAir;
layout(rgba16f) uniform writeonly image2D outGlow;   // of lamps, in the whole column: the glow before the sky
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
    vec3 true_sun = frame_true_sun(), sky = 0.5 * (sky_radiance(vec3(0.0, 1.0, 0.0), sun) + sky_radiance(normalize(vec3(true_sun.x, 0.15, true_sun.z) + vec3(1e-4, 0.0, 0.0)), sun));
    float eye = RX_AIR_GROUND + RX_AIR_EYE, sun_cosine = true_sun.y;
    vec3 many = frame.sky_strength * RX_AIR_PI * textureLod(scattered, rx_scattered_place(eye, sun_cosine), 0.0).rgb;
    float rayleigh = rx_rayleigh_phase(cosine), mie = rx_mie_phase(cosine, RX_AIR_MIE_G), misty = rx_mie_phase(cosine, 0.6);
    vec3 light = vec3(0.0), glow = vec3(0.0);
    vec3 clear = vec3(1.0);
    vec3 eye_place = vec3(frame.camera_cell) + frame.camera_frac;
    float camera_height = eye_place.y;
    for (int i = 0; i < size.z; ++i) {
        ivec3 slice = ivec3(column, i);
        float from = slice_depth(float(i) / float(size.z)), to = slice_depth(float(i + 1) / float(size.z)), length = to - from;
        float height = camera_height + 0.5 * (from + to) * dir.y;
        vec4 of_sun = texelFetch(sunBySlice, slice, 0), of_sky = texelFetch(skyBySlice, slice, 0), of_lamps = texelFetch(lampsBySlice, slice, 0);
        vec3 lit = of_sun.rgb * sun_through_clouds(eye_place + 0.5 * (from + to) * dir), above = of_sky.rgb;
        RxAir air = rx_air(max(RX_AIR_EYE + 0.001 * (height - camera_height), 0.0));
        float thick = 0.001 * push.mist * mist_between(camera_height + from * dir.y, camera_height + to * dir.y, push.mist_height, push.mist_floor);
        vec3 loss = air.extinction * km + thick;
        vec3 lamps = 0.9 * thick * of_lamps.rgb;
        vec3 sent = sunlight * lit * (air.rayleigh * km * rayleigh + air.mie * km * mie + 0.9 * thick * misty)
                  + above * (many * (air.rayleigh + air.mie) * km + 0.9 * thick * sky)
                  + lamps;
        vec3 through = exp(-loss * length);
        light += clear * sent * (1.0 - through) / max(loss, vec3(1e-9));
        glow += clear * lamps * (1.0 - through) / max(loss, vec3(1e-9));
        clear *= through;
        // The surface behind is seen through gray air: there is one number for that.
        imageStore(outAir, slice, vec4(light, dot(clear, vec3(1.0 / 3.0))));
    }
    imageStore(outGlow, column, vec4(glow, 0.0));
}
