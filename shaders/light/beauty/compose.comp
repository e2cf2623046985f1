// Composes the picture: the surface, its mirror image, the sky with its sun, moon, stars and clouds, and the air before all of it.
#version 460
#include "../scene.glsl"
#include "air_slices.glsl"
#include "beyond.glsl"
#include "lights_above.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba32i) uniform readonly iimage2D hits;
layout(rgba32f) uniform readonly image2D places;
layout(rgba32f) uniform readonly image2D radiance;
uniform sampler2D gloss;
uniform sampler3D air;
uniform sampler2D clouds;
uniform sampler2D glow;
layout(rgba16f) uniform writeonly image2D outSeen;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), size = imageSize(outSeen);
    if (any(greaterThanEqual(pixel, size))) return;
    vec3 color = imageLoad(radiance, pixel).rgb;
    int word = imageLoad(hits, pixel).w;
    float depth = imageLoad(places, pixel).z;
    bool land = word < 0 && depth > 0.0;
    vec3 sun = frame_sun(), dir = pixel_direction(pixel, size);
    // The sky and the haze have their own air. Mist that lamps light hangs before them, too.
    vec3 lit_mist = word < 0 ? textureLod(glow, (vec2(pixel) + 0.5) / vec2(size), 0.0).rgb : vec3(0.0);
    if (word < 0 && !land) {
        // Below the horizon of a world without land around it is only haze.
        if (dir.y < 0.0) {
            color = mix(horizon_radiance(dir, sun), color, 1.0 - smoothstep(-0.6, 0.0, dir.y));
        } else {
            float wide = 2.0 * frame.tan_half_fov.y / float(size.y), hidden;
            vec3 moon = moon_disc(dir, wide, hidden);
            color += sun_disc(dir) + moon + (1.0 - hidden) * stars(dir, wide);
        }
    } else {
        vec4 coat = texelFetch(gloss, pixel, 0);
        color = color * max(coat.a, 0.0) + coat.rgb;
        float slice = slice_of(depth) - 0.5 / 32.0;
        vec4 before = textureLod(air, vec3((vec2(pixel) + 0.5) / vec2(size), slice), 0.0);
        // Before the centre of the first slice there is proportionally less.
        before = mix(vec4(0.0, 0.0, 0.0, 1.0), before, clamp(depth / slice_depth(1.0 / 32.0), 0.0, 1.0));
        color = color * before.a + before.rgb;
        if (land) color = mix(color, horizon_radiance(dir, sun) + lit_mist, land_haze(depth));
    }
    // The clouds before it: all of them before the sky, and before land as far as it lies behind them.
    float from, until, far = word < 0 && !land ? 1e9 : depth;
    if (cloud_span(float(frame.camera_cell.y) + frame.camera_frac.y, dir, from, until) && from < far) {
        vec4 cloud = textureLod(clouds, (vec2(pixel) + 0.5) / vec2(size), 0.0);
        color = mix(color, color * cloud.a + cloud.rgb, min((far - from) / (until - from), 1.0));
    }
    if (word < 0 && !land) color += lit_mist;
    imageStore(outSeen, pixel, vec4(color, 1.0));
}
