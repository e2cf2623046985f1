// Whether the sun and the sky reach the air: two rays for each slice of the view (air_slices.glsl), at another depth in each frame. Each slice has
// a thread of its own, because one thread for a whole column would leave most of a GPU without work. What earlier frames have found at a place
// goes into a mean that follows the camera.
// With PANES, the rays go through clear bodies of at most so many voxels.
#version 460
#include <raxel/scene.glsl>
#include <raxel/random.glsl>
#include "../scene.glsl"
#include "../change.glsl"
#include "air_slices.glsl"
#include <raxel/light/reproject.glsl>
#ifdef PANES
#include <raxel/light/body.glsl>
#endif

layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba32i) uniform readonly iimage2D hits;
layout(rgba32f) uniform readonly image2D places;
layout(rgba16f) uniform writeonly image3D outSun;   // share of sunlight that comes through
layout(rgba16f) uniform writeonly image3D outSky;   // share of skylight
uniform sampler3D sunBefore;                        // those of the last frame; alpha is the number of frames in the mean
uniform sampler3D skyBefore;
layout(push_constant) uniform Push { mat4 world_to_view; ivec3 cell; vec3 frac; } push;   // the camera of the last frame

const float MOST = 12.0;   // frames in a mean

#include "air_view.glsl"

// The share of light that comes along a ray.
vec3 open_share(RxSceneRay ray) {
    vec3 share = vec3(1.0);
    RxHit block;
    bool blocked = rx_trace_places(ray, block);
#ifdef PANES
    for (int pane = 0; pane < 2 && blocked && rx_pass_panes(block, PANES, ray, share); ++pane) blocked = rx_trace_places(ray, block);
#endif
    return blocked ? vec3(0.0) : share;
}

void main() {
    ivec3 slice = ivec3(gl_GlobalInvocationID), size = imageSize(outSun);
    if (any(greaterThanEqual(slice, size))) return;
    vec3 sun = frame_sun();
    float t = slice_place(slice, size);
    vec3 lit = vec3(1.0), above = vec3(1.0);
    uint seed = rx_hash(rx_hash(slice_seed(slice)) ^ frame.index);
    float reach;
    vec3 way = seen_way(slice, size, t, seed, reach), at = frame.camera_frac + min(t, reach) * way;
    ivec3 cell = ivec3(floor(at));
    vec3 frac = at - vec3(cell);
    cell += frame.camera_cell;
    // Air farther away counts as open.
    if (distance(at, frame.camera_frac) < 600.0) {
        lit = sun_irradiance(sun) == vec3(0.0) ? vec3(0.0) : open_share(rx_scene_ray(rx_ray(cell, frac, sun)));
        // In caves and rooms little of the sky reaches the mist: one ray to anywhere above says how much.
        vec2 sky = rx_sobol(frame.index, 1u, rx_hash(slice_seed(slice)));
        float angle = 2.0 * RX_PI * sky.x, side = sqrt(1.0 - sky.y * sky.y);
        vec3 up = vec3(side * cos(angle), sky.y + 1e-3, side * sin(angle));
        above = open_share(rx_scene_ray(rx_ray(cell, frac, up)));
    }
    vec3 place;
    float frames = 0.0;
    if (place_before(slice, size, place)) {
        vec4 sun_before = texture(sunBefore, place);
        frames = min(sun_before.a, MOST - 1.0);
        if (state.changed != 0u) frames = min(frames, floor(state.cap));
        lit = mix(sun_before.rgb, lit, 1.0 / (frames + 1.0));
        above = mix(texture(skyBefore, place).rgb, above, 1.0 / (frames + 1.0));
    }
    imageStore(outSun, slice, vec4(lit, frames + 1.0));
    imageStore(outSky, slice, vec4(above, frames + 1.0));
}
