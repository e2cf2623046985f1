// Whether the sun and the sky reach the air: some rays for each slice of the view (air_slices.glsl), at other depths in each frame. Each
// slice has a thread of its own, because one thread for a whole column would leave most of a GPU without work. The light that earlier
// frames have found at a place goes into a mean that follows the camera. With PANES, the rays go through clear bodies of at most PANES
// voxels.
#version 460
#include <raxel/scene.glsl>
#include <raxel/random.glsl>
#include "../scene.glsl"
#include "../change.glsl"
#include "air_slices.glsl"
#include <raxel/light/reproject.glsl>
#include "air_mean.glsl"
#ifdef PANES
#include <raxel/light/body.glsl>
#endif

layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba32i) uniform readonly iimage2D hits;
layout(rgba32f) uniform readonly image2D places;
layout(rgba32f) uniform writeonly image3D outSun;   // share of sunlight that comes through
layout(rgba32f) uniform writeonly image3D outSky;   // share of skylight
uniform sampler3D sunBefore;                        // those of the last frame; alpha is the number of frames in the mean, negative where a wall hid the slice in all of them
uniform sampler3D skyBefore;
layout(push_constant) uniform Push { mat4 world_to_view; ivec3 cell; vec3 frac; } push;   // the camera of the last frame

const float MOST = 4.0, MOST_OF_SKY = 24.0, MOST_AT_REST = 512.0;   // frames in a mean
const float FAST = 12.0;         // frames that still count (change.glsl) below which the sun moves fast
const float MOST_FAST = 3.0;     // frames in a mean then
const uint RAYS_IN_MOTION = 3u;  // to the sun

#include "air_view.glsl"

// The share of light that comes along a ray.
vec3 open_share(RxSceneRay ray) {
    vec3 share = vec3(1.0);
#ifdef PANES
    RxHit block;
    bool blocked = rx_trace_places(ray, block);
    for (int pane = 0; pane < 2 && blocked && rx_pass_panes(block, PANES, ray, share); ++pane) blocked = rx_trace_places(ray, block);
#else
    bool blocked = rx_meets_places(ray);
#endif
    return blocked ? vec3(0.0) : share;
}

void main() {
    ivec3 slice = ivec3(gl_GlobalInvocationID), size = imageSize(outSun);
    if (any(greaterThanEqual(slice, size))) return;
    vec3 sun = frame_sun();
    uint seed = rx_hash(rx_hash(slice_seed(slice)) ^ frame.index);
    bool rests = frame.still > 0u, fast = state.changed != 0u && state.cap < FAST;
    vec3 lit = vec3(0.0), above = vec3(1.0), before_walls = vec3(0.0);
    float seen_rays = 0.0;
    bool sees_sky = false;
    // Rays to the sun, and one to anywhere above: in caves and rooms little of the sky reaches the mist.
    uint rays = rests ? 1u : RAYS_IN_MOTION;
    for (uint i = 0u; i <= rays; ++i) {
        bool to_sky = i == rays;
        uint index = to_sky ? frame.index : frame.index * rays + i;
        float t = slice_place(slice, size, index), reach;
        vec3 way = seen_way(slice, size, t, seed, reach), at = frame.camera_frac + min(t, reach) * way, to = sun, open = vec3(1.0);
        bool seen = t <= reach;
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
        if (to_sky) {
            above = open;
            sees_sky = seen;
        } else if (seen) {
            lit += open;
            seen_rays += 1.0;
        } else {
            before_walls += open / float(rays);
        }
    }
    bool sees_sun = seen_rays > 0.0;
    lit = sees_sun ? lit / seen_rays : before_walls;
    // A place that an edit has opened or closed is new at once. The sky is as open under another sun.
    float most = rests ? MOST_AT_REST : fast ? MOST_FAST : MOST, most_of_sky = rests ? MOST_AT_REST : MOST_OF_SKY;
    if (state.changed != 0u && state.cap < 1.0) most = 1.0;
    if (state.changed != 0u && state.cap < 0.25) most_of_sky = 1.0;
    Mean sun_before = Mean(vec3(0.0), 0.0, false), sky_before = sun_before;
    vec3 place;
    if (place_before(slice, size, place)) {
        sun_before = mean_between(sunBefore, place);
        sky_before = mean_between(skyBefore, place);
    }
    imageStore(outSun, slice, mean_with(sun_before, lit, sees_sun, most));
    imageStore(outSky, slice, mean_with(sky_before, above, sees_sky, most_of_sky));
}
