// Temporal anti-aliasing: each frame looks through another place of each pixel, and the pixel's earlier light goes into a mean. In motion,
// the earlier light follows the light around the pixel, and must lie within its present range; at rest, the mean is of all frames. With
// WAVES, water that moves has a short memory, and everything else stays as it is after 512 frames at rest, when the passes that find first
// hits have stopped. A place on an instance is followed as the instance moves. With PANES, what a pane shows is followed.
#version 460
#ifdef WAVES
#include <raxel/world.glsl>
#endif
#ifdef RX_BINDS_Poses
#include <raxel/place.glsl>
#endif
#include "../scene.glsl"
#include <raxel/light/reproject.glsl>
#include "cubic.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba32i) uniform readonly iimage2D hits;
layout(rgba32f) uniform readonly image2D places;
#ifdef RX_BINDS_Poses
#include "../moved.glsl"
#endif
uniform sampler2D seen;
uniform sampler2D before;   // light, frames
#ifdef PANES
uniform sampler2D gloss;
#endif
layout(rgba32f) uniform writeonly image2D outAverage;
layout(rgba16f) uniform writeonly image2D outPicture;
layout(push_constant) uniform Push { mat4 world_to_view; ivec3 cell; vec3 frac; } push;

const float MOST_IN_MOTION = 4.0, MOST_ON_WATER = 3.0;
const float BRIGHTER = 2.0;   // than the light around a pixel now may its mean be
const uint STALE = 32u;   // frames at rest in which light from before a change may still be in the mean

// Bright colours count less, so that one bright sample in a mean does not flicker.
vec3 pressed(vec3 light) {
    return light / (1.0 + max(light.x, max(light.y, light.z)));
}

vec3 released(vec3 light) {
    return light / max(1.0 - max(light.x, max(light.y, light.z)), 1e-4);
}

// The range of the light around a pixel now: `deviations` standard deviations around the mean, and at most
// BRIGHTER times as bright as the brightest.
void range_around(ivec2 pixel, ivec2 size, float deviations, out vec3 low, out vec3 high) {
    vec3 mean = vec3(0.0), square = vec3(0.0), most = vec3(0.0);
    for (int i = 0; i < 9; ++i) {
        vec3 c = pressed(texelFetch(seen, clamp(pixel + ivec2(i % 3, i / 3) - 1, ivec2(0), size - 1), 0).rgb);
        mean += c / 9.0;
        square += c * c / 9.0;
        most = max(most, c);
    }
    vec3 wide = deviations * sqrt(max(square - mean * mean, 0.0));
    low = mean - wide;
    high = min(mean + wide, pressed(BRIGHTER * released(most)));
}

// The mean of earlier frames at a place of the picture, and its frames.
vec4 mean_at(vec2 at, ivec2 size) {
    ivec2 base = ivec2(floor(at - 0.5));
    vec2 part = at - 0.5 - vec2(base);
    vec4 along = cubic(part.x), down = cubic(part.y), mean = vec4(0.0);
    for (int i = 0; i < 16; ++i) {
        vec4 tap = texelFetch(before, clamp(base + ivec2(i & 3, i >> 2) - 1, ivec2(0), size - 1), 0);
        mean += along[i & 3] * down[i >> 2] * vec4(pressed(tap.rgb), tap.w);
    }
    return mean;
}

// The mean of earlier frames over 3 x 3 pixels around a place of the picture.
vec3 wide_mean_at(vec2 at, ivec2 size) {
    ivec2 base = ivec2(floor(at - 0.5));
    vec2 part = at - 0.5 - vec2(base);
    vec4 along = vec4(1.0 - part.x, 1.0, 1.0, part.x) / 3.0, down = vec4(1.0 - part.y, 1.0, 1.0, part.y) / 3.0;
    vec3 mean = vec3(0.0);
    for (int i = 0; i < 16; ++i) {
        ivec2 tap = clamp(base + ivec2(i & 3, i >> 2) - 1, ivec2(0), size - 1);
        mean += along[i & 3] * down[i >> 2] * pressed(texelFetch(before, tap, 0).rgb);
    }
    return mean;
}

// By how much the light around a pixel differs from the mean of earlier frames, as far as edges between pixels do not explain it. `at` is the
// place in that mean that this frame has looked through; `low` and `high` are those of range_around for one deviation.
vec3 change_around(vec2 at, ivec2 size, vec3 low, vec3 high) {
    vec3 change = 0.5 * (low + high) - wide_mean_at(at, size);
    vec3 chance = (high - low) / 6.0;   // the mean of nine pixels has a third of the deviation of one
    return change * (change * change / max(change * change + chance * chance, vec3(1e-20)));
}

#ifdef PANES
// Follows what a pane shows, at `way` from the last camera, if the same pane was before it there; else the pane, whose place is in `at` if it was `there`.
// The pane's colours move with the pane: a pixel lies as far beside this one now as both places lay apart.
bool follow_behind(ivec2 pixel, ivec2 size, ivec4 hit, vec3 way, inout vec2 at, bool there) {
    vec2 behind;
    if (!there || !rx_reproject(way, mat3(push.world_to_view), frame.tan_half_fov, vec2(size), behind)) return there;
    vec2 apart = behind - at;
    ivec2 from = pixel + ivec2(floor(apart)), to = pixel + ivec2(ceil(apart));
    for (int i = 0; i < 4; ++i) {
        ivec2 other = ivec2((i & 1) != 0 ? to.x : from.x, (i >> 1) != 0 ? to.y : from.y);
        if (any(lessThan(other, ivec2(0))) || any(greaterThanEqual(other, size)) || imageLoad(hits, other).w != hit.w) return there;
    }
    at = behind;
    return true;
}
#endif

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), size = imageSize(outAverage);
    if (any(greaterThanEqual(pixel, size))) return;
    vec3 now = pressed(texelFetch(seen, pixel, 0).rgb);
    vec3 result = now;
    float frames = 1.0;
    bool water = false;
#ifdef WAVES
    int word = imageLoad(hits, pixel).w;
    if (word >= 0 && hit_face(word) == RX_FACE_POS_Y) water = rx_material_properties(hit_material(word)).transparency > 0.0;
    if (frame.still >= 512u && !water) {
        vec4 old = texelFetch(before, pixel, 0);
        imageStore(outAverage, pixel, old);
        imageStore(outPicture, pixel, vec4(old.rgb, 1.0));
        return;
    }
#endif
    if (frame.still > 0u) {
        vec4 old = texelFetch(before, pixel, 0);
        frames = min(old.w, water ? MOST_ON_WATER : float(frame.still)) + 1.0;
        // The mean of the frames in motion has little weight against the frames that follow.
        vec3 mean = pressed(old.rgb);
        if (frame.still < STALE && !water) {
            vec3 low, high;
            range_around(pixel, size, 1.5, low, high);
            mean = clamp(mean, low, high);
        }
        result = mix(mean, now, 1.0 / frames);
    } else {
        ivec4 hit = imageLoad(hits, pixel);
        float depth = imageLoad(places, pixel).z;
        vec3 dir = pixel_direction(pixel, size);
        // The centre of the pixel is followed, not the place that this frame has looked through.
        vec3 camera = vec3(frame.camera_cell - push.cell) + (frame.camera_frac - push.frac);
        vec3 way = depth == 0.0 && hit.w < 0 ? 1e5 * dir : camera + depth * dir;
#ifdef RX_BINDS_Poses
        if (hit.w >= 0 && rx_is_on_instance(hit_face(hit.w))) way = moved_from(hit.xyz, hit_face(hit.w), imageLoad(places, pixel).xy, push.cell, push.frac);
#endif
        vec2 at;
        bool there = rx_reproject(way, mat3(push.world_to_view), frame.tan_half_fov, vec2(size), at);
#ifdef PANES
        // A pane shows something farther away.
        float share = texelFetch(gloss, pixel, 0).a;
        if (share < 0.0) there = follow_behind(pixel, size, hit, camera - share * dir, at, there);
#endif
        if (there) {
            vec2 seen_at = at;
            at -= pixel_place(pixel) - (vec2(pixel) + 0.5);
            vec3 low, high;
            range_around(pixel, size, 1.0, low, high);
            vec4 old = mean_at(at, size);
            if (old.w > 0.0) {
                frames = min(old.w, MOST_IN_MOTION - 1.0) + 1.0;
                result = mix(clamp(old.rgb + change_around(seen_at, size, low, high), low, high), now, 1.0 / frames);
            }
        }
    }
    vec3 light = released(result);
    imageStore(outAverage, pixel, vec4(light, frames));
    imageStore(outPicture, pixel, vec4(light, 1.0));
}
