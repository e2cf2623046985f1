// Puts together what a pixel sees: the surface, what it mirrors, the sky with its sun and clouds, and the air before all of it.
#version 460
#include "../scene.glsl"
#include "air_slices.glsl"
#include "beyond.glsl"
#include "clouds.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba32i) uniform readonly iimage2D hits;
layout(rgba32f) uniform readonly image2D places;
layout(rgba32f) uniform readonly image2D radiance;
uniform sampler2D gloss;
uniform sampler3D air;
layout(rgba16f) uniform writeonly image2D outSeen;
layout(push_constant) uniform Push { float clouds; } push;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), size = imageSize(outSeen);
    if (any(greaterThanEqual(pixel, size))) return;
    vec3 color = imageLoad(radiance, pixel).rgb;
    int word = imageLoad(hits, pixel).w;
    float depth = imageLoad(places, pixel).z;
    bool land = word < 0 && depth > 0.0;
    vec3 sun = frame_sun(), dir = pixel_direction(pixel, size);
    if (word < 0 && !land) {
        float cover = 0.0;
        // Below the horizon of a world without land around it is only haze.
        if (dir.y < 0.0) color = mix(horizon_radiance(dir, sun), color, 1.0 - smoothstep(-0.6, 0.0, dir.y));
        if (push.clouds > 0.0 && dir.y > 0.0) color = with_clouds(color, dir, sun, push.clouds, cover);
        // The disc, darker at its limb; a thousandth of its radiance is as much as a screen can show.
        float disc = smoothstep(1.0 - 1.6 * RX_SUN_CAP, 1.0 - 0.4 * RX_SUN_CAP, dot(dir, sun));
        color += (1.0 - cover) * disc * 15.0 * sun_irradiance(sun);
    } else {
        vec4 coat = texelFetch(gloss, pixel, 0);
        color = color * coat.a + coat.rgb;
        float slice = slice_of(depth) - 0.5 / 32.0;
        vec4 before = textureLod(air, vec3((vec2(pixel) + 0.5) / vec2(size), slice), 0.0);
        // Before the middle of the first slice there is as much less.
        before = mix(vec4(0.0, 0.0, 0.0, 1.0), before, clamp(depth / slice_depth(1.0 / 32.0), 0.0, 1.0));
        color = color * before.a + before.rgb;
        if (land) color = mix(color, horizon_radiance(dir, sun), land_haze(depth));
    }
    imageStore(outSeen, pixel, vec4(color, 1.0));
}
