// The sun: one ray a pixel and frame to a random place in its disc. Under a still camera, the mean over all frames counts. While the camera
// moves, a mean would blur the edges of shadows with each step, so a frame stands for itself (`history` 0). A pixel is in doubt if its
// neighbours or its last frame found something else. It gets `rays` more rays at once. The pixel's position in the last frame is exact, and a
// value there counts only for the same face of the same voxel. With JITTER, whose frames are averaged, pixels in doubt share the results of
// their rays, and more of them are in doubt. With ONE_RAY, no pixel gets more than one: for graphs that average whole pictures. With SUN_TEXELS,
// a face that has texels (unwrapped.glsl) knows its sunlight by itself. With PANES, rays go through clear bodies of at most PANES
// voxels, with one ray a pixel, too. Their light is kept apart, with its colours. Its mean is of some frames in motion, too.
#version 460
#if defined(PANES) && !defined(ONE_RAY)
#define ONE_RAY 1
#endif
#include <raxel/scene.glsl>
#include "scene.glsl"
#include <raxel/light/reproject.glsl>
#ifdef RX_BINDS_instances
#include "moved.glsl"
#endif

const uint SIDE = 8u, PIXELS = SIDE * SIDE;
layout(local_size_x = SIDE, local_size_y = SIDE) in;
layout(rgba32i) uniform readonly iimage2D hits;
layout(rgba32f) uniform readonly image2D places;
uniform isampler2D hitsBefore;
uniform sampler2D sunBefore;
layout(rg32f) uniform writeonly image2D outSun;
#ifdef PANES
#include <raxel/light/body.glsl>
layout(rgba32f) uniform writeonly image2D outStained;   // share of the sun times the cosine; frames in the mean
uniform sampler2D stainedBefore;
const float MOST_STAINED = 8.0;                         // of earlier frames in motion
#endif
#ifdef SUN_TEXELS
layout(r32ui) uniform readonly uimage2D slots;
layout(std430) readonly buffer SunTexels { vec2 sun_texels[]; };
#include "unwrapped.glsl"
#endif
#include "change.glsl"
#ifdef STIRS
layout(std430) buffer Stirred { uint stirred[]; };
#include "stirred.glsl"
const float STIRS_FROM = 0.05;   // change of the share of the sun
#endif
layout(push_constant) uniform Push { mat4 world_to_view; ivec3 cell; int history; vec3 frac; int rays; } push;

#ifndef ONE_RAY
const float ONE = 16777216.0;       // cosines are added as whole numbers, so that their order does not matter
const uint STEADY = 16u;            // frames after the last change until no pixel is in doubt any more

#ifdef JITTER
const int NEAR = 2;                 // pixels that a pixel looks at, each way
#else
const int NEAR = 1;
#endif
const float APART = 2.0;            // at this many variances of their difference, two pixels hardly count as alike

const uint NOT_ASKED = 7u;
shared uint found[PIXELS];          // the sum of the cosines of the rays that reach the sun
shared uint facing[PIXELS];         // face; NOT_ASKED where the sun is not asked for
shared uint taken[PIXELS];          // rays
#ifdef JITTER
shared int plane[PIXELS];           // where on its axis the face lies
#endif
shared uint doubtful[PIXELS];       // pixels that get more rays
shared uint doubts;
shared uint asked_for;              // whether any pixel asks for the sun
#endif

#ifdef PANES
vec4 stained_before = vec4(0.0);   // that of earlier frames
#endif

// The result of earlier frames: share of the sun times the cosine, samples.
vec2 before(ivec2 pixel, ivec2 size, ivec4 hit, vec3 place) {
    vec2 at;
    vec3 from_camera = vec3(frame.camera_cell - push.cell) + (frame.camera_frac - push.frac) + place.z * pixel_direction(pixel, size);
#ifdef RX_BINDS_instances
    if (rx_is_on_instance(hit_face(hit.w))) from_camera = moved_from(hit.xyz, hit_face(hit.w), place.xy, push.cell, push.frac);
#endif
    if (!rx_reproject(from_camera, mat3(push.world_to_view), frame.tan_half_fov, vec2(size), at)) return vec2(0.0);
    // Follow the centre of the pixel, not this frame's place in it: otherwise a mean of many frames blurs
    // shadows over their faces.
    at -= pixel_place(pixel) - (vec2(pixel) + 0.5);
    ivec2 base = ivec2(floor(at - 0.5));
    vec2 part = at - 0.5 - vec2(base), old = vec2(0.0);
    float weight = 0.0;
    for (int i = 0; i < 4; ++i) {
        ivec2 tap = base + ivec2(i & 1, i >> 1);
        if (any(lessThan(tap, ivec2(0))) || any(greaterThanEqual(tap, size))) continue;
        if (texelFetch(hitsBefore, tap, 0) != hit) continue;
        float w = ((i & 1) != 0 ? part.x : 1.0 - part.x) * ((i >> 1) != 0 ? part.y : 1.0 - part.y);
        old += w * texelFetch(sunBefore, tap, 0).xy;
#ifdef PANES
        stained_before += w * texelFetch(stainedBefore, tap, 0);
#endif
        weight += w;
    }
#ifdef PANES
    stained_before = weight > 1e-3 ? stained_before / weight : vec4(0.0);
#endif
    return weight > 1e-3 ? old / weight : vec2(0.0);
}

#ifdef PANES
vec3 stained = vec3(0.0);

// As below; light through panes is in `stained` alone.
float sun_ray(ivec3 voxel, uint face, vec2 uv, vec3 to) {
    vec3 left = vec3(dot(rx_place_normal(voxel, face), to));
    if (left.x <= 0.0) return 0.0;
    RxHit block;
    RxSceneRay ray = rx_ray_from_place(voxel, face, uv, to);
    bool blocked = false, through = false;
    for (uint pane = 0u;; ++pane) {
        blocked = rx_trace_places(ray, block);
        if (!blocked || pane == 3u || !rx_pass_panes(block, PANES, ray, left)) break;
        through = true;
    }
    if (through && !blocked) stained = left;
    return blocked || through ? 0.0 : left.x;
}
#else
// The cosine of a ray to the sun, 0 where it does not get there.
float sun_ray(ivec3 voxel, uint face, vec2 uv, vec3 to) {
    float cosine = dot(rx_place_normal(voxel, face), to);
    return cosine <= 0.0 || rx_meets_places(rx_ray_from_place(voxel, face, uv, to)) ? 0.0 : cosine;
}
#endif

// The `index`-th place in the disc for a pixel.
vec3 sun_place(ivec2 pixel, vec3 sun, uint index) {
    return rx_sun_point(sun, rx_sobol(index, 0u, scene_seed(uint(pixel.x) + rx_hash(uint(pixel.y)))));
}

#ifndef ONE_RAY
// The pixel of the group that is `step` pixels from another one; PIXELS where it lies in another group or faces another way.
uint beside(uint own, ivec2 step) {
    ivec2 at = ivec2(own % SIDE, own / SIDE) + step;
    if (any(lessThan(at, ivec2(0))) || any(greaterThanEqual(at, ivec2(SIDE)))) return PIXELS;
    uint other = uint(at.y) * SIDE + uint(at.x);
    return facing[other] == facing[own] ? other : PIXELS;
}

#ifdef JITTER
// Merges the results of a pixel and of the pixels around it, as far as chance explains the difference. Half shadows become smooth, and sharp
// edges stay in place. `most` is the cosine of a face without shadow.
float shared_share(uint own, float most) {
    float mine = float(found[own]) * (16.0 / ONE), n = float(taken[own]), sum = mine, rays = n;
    for (int y = -NEAR; y <= NEAR; ++y) {
        for (int x = -NEAR; x <= NEAR; ++x) {
            uint other = x == 0 && y == 0 ? PIXELS : beside(own, ivec2(x, y));
            if (other == PIXELS || plane[other] != plane[own]) continue;
            float theirs = float(found[other]) * (16.0 / ONE), m = float(taken[other]);
            float pooled = clamp((mine + theirs) / ((n + m) * most), 0.0, 1.0), apart = mine / n - theirs / m;
            float weight = exp(-apart * apart / max(APART * most * most * pooled * (1.0 - pooled) * (1.0 / n + 1.0 / m), 1e-12));
            sum += weight * theirs;
            rays += weight * m;
        }
    }
    return sum / rays;
}
#endif
#endif

// A mean with new rays in it: `fresh` is the mean of `n`. While everything stands still, it is of all frames; a sun that has moved leaves little.
vec2 with_fresh(vec2 old, float fresh, float n, float history, float a_frame) {
    float most = history + float(frame.still) * a_frame;
    if (state.changed != 0u) most = min(most, state.cap);
    float kept = min(old.y, most);
    return vec2(old.x + (fresh - old.x) * n / (kept + n), kept + n);
}

void main() {
    ivec2 size = imageSize(outSun), pixel = ivec2(gl_GlobalInvocationID.xy);
    bool inside = all(lessThan(pixel, size));
    vec3 sun = frame_sun();
    ivec4 hit = inside ? imageLoad(hits, pixel) : ivec4(0, 0, 0, -1);
    vec4 place = inside ? imageLoad(places, pixel) : vec4(0.0);
    uint face = hit_face(hit.w);
    // A face that looks away from all of the disc needs no ray.
    bool asks = hit.w >= 0 && face != RX_FACE_INSIDE && dot(rx_place_normal(hit.xyz, face), sun) > -0.00466 && frame.sun_strength > 0.0;
    vec2 result = vec2(0.0, 1.0);
#ifdef SUN_TEXELS
    uint slot = inside ? imageLoad(slots, pixel).x : 0xffffffffu, block_here = slot == 0xffffffffu ? NO_BLOCK : block_of(slot);
    vec2 texel = asks && block_here != NO_BLOCK ? sun_texels[texel_in(block_here, place.xy)] : vec2(0.0);
    if (texel.y > 0.0) {
        result = vec2(texel.x, min(texel.y, float(push.history)));
        asks = false;
    }
#endif
#ifdef ONE_RAY
    bool remembers = push.history > 0 || frame.still > 0u;
#else
    const bool remembers = true;   // the last frame decides whether a pixel is in doubt
#endif
#ifdef PANES
    // Light through panes has a mean in motion, too.
    vec2 old = asks ? before(pixel, size, hit, place.xyz) : vec2(0.0);
    if (!remembers) old = vec2(0.0);
#else
    vec2 old = asks && remembers ? before(pixel, size, hit, place.xyz) : vec2(0.0);
#endif

#ifdef ONE_RAY
    if (asks) result = with_fresh(old, sun_ray(hit.xyz, face, place.xy, sun_place(pixel, sun, frame.index)), 1.0, float(push.history), 1.0);
#else
    uint own = gl_LocalInvocationIndex;
    found[own] = 0u;
    facing[own] = asks ? face : NOT_ASKED;
    taken[own] = 1u;
#ifdef JITTER
    plane[own] = hit.xyz[min(RX_FACE_PART(face) >> 1, 2u)];
#ifdef RX_BINDS_instances
    if (rx_is_on_instance(face)) plane[own] = int(rx_hash(hit.xyz));
#endif
#endif
    if (own == 0u) {
        doubts = 0u;
        asked_for = 0u;
    }
    barrier();
    if (asks) asked_for = 1u;
    barrier();

    // A ray for each pixel, and then those of pixels in doubt, shared among all threads.
    uint rays = uint(max(push.rays, 0)), jobs = asked_for * PIXELS;
    bool doubt = false;
    for (uint turn = 0u; turn < 2u; ++turn) {
        for (uint job = own; job < jobs; job += PIXELS) {
            uint which = turn == 0u ? job : doubtful[job / rays];
            if (facing[which] == NOT_ASKED) continue;
            ivec2 there = ivec2(gl_WorkGroupID.xy * SIDE + uvec2(which % SIDE, which / SIDE));
            vec3 to = sun_place(there, sun, frame.index * (rays + 1u) + (turn == 0u ? 0u : 1u + job % rays));
            float cosine = sun_ray(imageLoad(hits, there).xyz, facing[which], imageLoad(places, there).xy, to);
            if (cosine > 0.0) atomicAdd(found[which], uint(cosine * ONE / 16.0));
        }
        barrier();
        if (turn == 1u || frame.still >= STEADY) break;
        uint mine = found[own];
        // Neighbours that look the same way and have found something else; an earlier frame that was between the two.
        for (int i = 0; asks && i < (2 * NEAR + 1) * (2 * NEAR + 1); ++i) {
            uint other = beside(own, ivec2(i % (2 * NEAR + 1), i / (2 * NEAR + 1)) - NEAR);
            doubt = doubt || other != PIXELS && (found[other] == 0u) != (mine == 0u);
        }
        float most = max(dot(rx_place_normal(hit.xyz, face), sun), 1e-3);
        doubt = asks && (doubt || old.y > 0.0 && abs(old.x - (mine == 0u ? 0.0 : most)) > 0.02 * most);
        if (doubt && rays > 0u) {
            doubtful[atomicAdd(doubts, 1u)] = own;
            taken[own] = rays + 1u;
        }
        barrier();
        jobs = doubts * rays;
    }
    if (asks) {
        float n = float(taken[own]), history = doubt ? float(push.history) : 0.0;
        float fresh = float(found[own]) * (16.0 / ONE) / n;
#ifdef JITTER
        if (doubt && frame.still == 0u) fresh = shared_share(own, max(dot(rx_place_normal(hit.xyz, face), sun), 1e-3));
#endif
        result = with_fresh(old, fresh, n, history, float(rays + 1u));
    }
#endif
    if (!inside) return;
#ifdef STIRS
    // The sun moves, and its share here is another than in the last frame.
    if (asks && state.changed != 0u && frame.still == 0u && old.y > 0.0 && face < RX_FACE_INSIDE) {
        float most = max(dot(rx_normal(face), sun), 1e-3);
        if (abs(result.x - old.x) > STIRS_FROM * most) stirred[stirred_place(hit.xyz >> 3)] = frame.index + 1u;
    }
#endif
    imageStore(outSun, pixel, vec4(result, 0.0, 0.0));
#ifdef PANES
    float most = MOST_STAINED + float(frame.still);
    if (state.changed != 0u) most = min(most, state.cap);
    float kept = min(stained_before.w, most);
    imageStore(outStained, pixel, asks ? vec4(mix(stained_before.rgb, stained, 1.0 / (kept + 1.0)), kept + 1.0) : vec4(0.0));
#endif
}
