// Draws the ground or the sea around a finite world, in pixels that see nothing of the world. Sun and sky light it, with a ray to each, and the world
// casts shadows. Leaves its light where smooth surfaces leave theirs, and its distance in `places`. Pixels that see the world end after one read.
#version 460
#include <raxel/world.glsl>
#include "../scene.glsl"
#include <raxel/light/sampling.glsl>
#include "beyond.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba32i) uniform readonly iimage2D hits;
layout(rgba32f) uniform writeonly image2D places;
layout(rgba16f) uniform writeonly image2D gloss;
layout(push_constant) uniform Push { ivec3 low; ivec3 high; } push;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), size = imageSize(gloss);
    if (any(greaterThanEqual(pixel, size)) || imageLoad(hits, pixel).w >= 0) return;
    Land land = read_land();
    vec3 dir = pixel_direction(pixel, size), to_sun = frame_sun();
    float t = land_distance(land, frame.camera_frac, dir);
    if (t < 0.0) return;
    vec3 at = frame.camera_frac + t * dir, skylight = sky_above(to_sun);
    float sunlit = 1.0, haze = land_haze(t);
    // Send no ray from places that the haze hides, nor from places far from the world.
    vec2 place = vec2(frame.camera_cell.xz) + at.xz;
    float away = length(max(max(vec2(push.low.xz) - place, place - vec2(push.high.xz)), 0.0)), tall = float(push.high.y) - land.level;
    uint seed = scene_seed(uint(pixel.x) + rx_hash(uint(pixel.y) + 911u));
    at.y = land.level - float(frame.camera_cell.y) + 1e-3;
    vec3 cell = floor(at);
    for (int i = 0; i < 2 && haze < 0.99; ++i) {
        bool sun = i == 0;
        if (sun ? to_sun.y <= 0.0 || away * to_sun.y > 1.5 * tall : away > 3.0 * tall) continue;
        vec3 to = sun ? rx_sun_point(to_sun, rx_sobol(frame.index, 0u, seed)) : rx_cosine_direction(RX_FACE_POS_Y, rx_sobol(frame.index, 1u, seed));
        RxHit hit;
        if (!rx_trace(rx_ray(frame.camera_cell + ivec3(cell), at - cell, to), hit)) continue;
        if (sun) sunlit = 0.0;
        else skylight *= hit.face == RX_FACE_INSIDE ? vec3(0.0) : 0.5 * rx_material_properties(hit.material).albedo;
    }
    vec3 light = land_radiance(land, at, dir, t, to_sun, sunlit, skylight);
    imageStore(gloss, pixel, vec4(light, 0.0));
    imageStore(places, pixel, vec4(0.0, 0.0, t, 0.0));
}
