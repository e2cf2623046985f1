// Whether the sun and the sky reach the air: some rays for each slice of the view (air_slices.glsl), at other depths in each frame. Each slice has
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
#include "cubic.glsl"
#ifdef PANES
#include <raxel/light/body.glsl>
#endif

layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba32i) uniform readonly iimage2D hits;
layout(rgba32f) uniform readonly image2D places;
layout(rgba32f) uniform writeonly image3D outSun;   // share of sunlight that comes through
layout(rgba32f) uniform writeonly image3D outSky;   // share of skylight
uniform sampler3D sunBefore;                        // those of the last frame; alpha is the number of frames in the mean, below 0 where a wall hid the slice
uniform sampler3D skyBefore;
layout(push_constant) uniform Push { mat4 world_to_view; ivec3 cell; vec3 frac; } push;   // the camera of the last frame

const float MOST = 4.0, MOST_OF_SKY = 24.0, MOST_AT_REST = 128.0;   // frames in a mean
const float FAST = 12.0;         // frames that still count (change.glsl) below which the sun moves fast
const float MOST_FAST = 3.0;     // frames in a mean then
const uint RAYS_IN_MOTION = 3u;  // to the sun

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
    uint seed = rx_hash(rx_hash(slice_seed(slice)) ^ frame.index);
    bool hidden = true, rests = frame.still > 0u, fast = state.changed != 0u && state.cap < FAST;
    vec3 lit = vec3(0.0), above = vec3(1.0);
    // Rays to the sun, and one to anywhere above: in caves and rooms little of the sky reaches the mist.
    uint rays = rests ? 1u : RAYS_IN_MOTION;
    for (uint i = 0u; i <= rays; ++i) {
        bool to_sky = i == rays;
        uint index = to_sky ? frame.index : frame.index * rays + i;
        float t = slice_place(slice, size, index), reach;
        vec3 way = seen_way(slice, size, t, seed, reach), at = frame.camera_frac + min(t, reach) * way, to = sun, open = vec3(1.0);
        hidden = hidden && slice_is_behind(slice, size, reach);
        if (to_sky) {
            vec2 sky = rx_sobol(index, 1u, rx_hash(slice_seed(slice)));
            float angle = 2.0 * RX_PI * sky.x, side = sqrt(1.0 - sky.y * sky.y);
            to = vec3(side * cos(angle), sky.y + 1e-3, side * sin(angle));
        }
        // Air farther away counts as open.
        if (distance(at, frame.camera_frac) < 600.0) {
            ivec3 cell = ivec3(floor(at));
            bool dark = !to_sky && sun_irradiance(sun) == vec3(0.0);
            open = dark ? vec3(0.0) : open_share(rx_scene_ray(rx_ray(frame.camera_cell + cell, at - vec3(cell), to)));
        }
        if (to_sky) above = open;
        else lit += open / float(rays);
    }
    vec3 place;
    float sun_frames = 0.0, sky_frames = 0.0;
    if (place_before(slice, size, place)) {
        bool seen = !hidden && slices_come_into_sight();
        vec4 sun_before = cubic_between(sunBefore, place, seen), sky_before = cubic_between(skyBefore, place, seen);
        sun_frames = min(sun_before.a, (rests ? MOST_AT_REST : fast ? MOST_FAST : MOST) - 1.0);
        sky_frames = min(sky_before.a, (rests ? MOST_AT_REST : MOST_OF_SKY) - 1.0);
        // What an edit has opened or closed is new at once. The sky is as open under another sun.
        if (state.changed != 0u && state.cap < 1.0) sun_frames = 0.0;
        if (state.changed != 0u && state.cap < 0.25) sky_frames = 0.0;
        lit = mix(sun_before.rgb, lit, 1.0 / (sun_frames + 1.0));
        above = mix(sky_before.rgb, above, 1.0 / (sky_frames + 1.0));
    }
    float sign = hidden ? -1.0 : 1.0;
    imageStore(outSun, slice, vec4(lit, sign * (sun_frames + 1.0)));
    imageStore(outSky, slice, vec4(above, sign * (sky_frames + 1.0)));
}
