// The sun: one ray a pixel and frame to a random place in its disc, averaged over time along the surface. Where a pixel was in the last
// frame is known exactly, and a value of that frame counts only if it is of the same face of the same voxel: no thresholds, and no
// trails. With SUN_TEXELS, a face that has texels (surface/unwrapped.glsl) knows its sunlight by itself.
// With PANES, rays go through clear bodies of at most so many voxels, and what they bring then is kept apart, in its colours and without a history.
#version 460
#include <raxel/world.glsl>
#include "scene.glsl"
#include <raxel/light/reproject.glsl>

layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba32i) uniform readonly iimage2D hits;
layout(rgba32f) uniform readonly image2D places;
layout(rgba32i) uniform readonly iimage2D hitsBefore;
layout(rg32f) uniform readonly image2D sunBefore;
layout(rg32f) uniform writeonly image2D outSun;
#ifdef PANES
#include <raxel/light/body.glsl>
layout(rgba16f) uniform writeonly image2D outStained;   // share of the sun times the cosine
#endif
#ifdef SUN_TEXELS
layout(r32ui) uniform readonly uimage2D slots;
layout(std430) readonly buffer SunTexels { vec2 sun_texels[]; };
#include "surface/unwrapped.glsl"
#endif
#include "change.glsl"
layout(push_constant) uniform Push { mat4 world_to_view; ivec3 cell; int history; vec3 frac; } push;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), size = imageSize(outSun);
    if (any(greaterThanEqual(pixel, size))) return;
    ivec4 hit = imageLoad(hits, pixel);
    vec4 place = imageLoad(places, pixel);
    uint face = hit_face(hit.w);
    vec3 sun = frame_sun();
#ifdef PANES
    imageStore(outStained, pixel, vec4(0.0));
#endif
    // A face that looks away from all of the disc needs no ray.
    if (hit.w < 0 || face == RX_FACE_INSIDE || dot(rx_normal(face), sun) <= -0.00466 || frame.sun_strength <= 0.0) {
        imageStore(outSun, pixel, vec4(0.0, 1.0, 0.0, 0.0));
        return;
    }
#ifdef SUN_TEXELS
    uint slot = imageLoad(slots, pixel).x, block_here = slot == 0xffffffffu ? NO_BLOCK : block_of(slot);
    vec2 texel = block_here == NO_BLOCK ? vec2(0.0) : sun_texels[texel_in(block_here, place.xy)];
    if (texel.y > 0.0) {
        imageStore(outSun, pixel, vec4(texel.x, min(texel.y, float(push.history)), 0.0, 0.0));
        return;
    }
#endif
    uint seed = scene_seed(uint(pixel.x) + rx_hash(uint(pixel.y)));
    vec3 to = rx_sun_point(sun, rx_sobol(frame.index, 0u, seed));
    float cosine = max(dot(rx_normal(face), to), 0.0);
    RxHit block;
    RxRay ray = rx_ray_from_face(hit.xyz, face, place.xy, to);
#ifdef PANES
    vec3 left = vec3(cosine);
    bool blocked = false, through = false;
    for (uint pane = 0u; cosine > 0.0; ++pane) {
        blocked = rx_trace(ray, block);
        if (!blocked || pane == 3u || !rx_pass_body(block, PANES, ray, left)) break;
        through = true;
    }
    if (through && !blocked) imageStore(outStained, pixel, vec4(left, 0.0));
    blocked = blocked || through;
#else
    bool blocked = cosine > 0.0 && rx_trace(ray, block);
#endif
    if (blocked) cosine = 0.0;

    vec2 old = vec2(0.0);
    vec2 at;
    vec3 dir = pixel_direction(pixel, size);
    vec3 from_camera = vec3(frame.camera_cell - push.cell) + (frame.camera_frac - push.frac) + place.z * dir;
    if (rx_reproject(from_camera, mat3(push.world_to_view), frame.tan_half_fov, vec2(size), at)) {
        ivec2 base = ivec2(floor(at - 0.5));
        vec2 part = at - 0.5 - vec2(base);
        float weight = 0.0;
        for (int i = 0; i < 4; ++i) {
            ivec2 tap = base + ivec2(i & 1, i >> 1);
            if (any(lessThan(tap, ivec2(0))) || any(greaterThanEqual(tap, size))) continue;
            if (imageLoad(hitsBefore, tap) != hit) continue;
            float w = ((i & 1) != 0 ? part.x : 1.0 - part.x) * ((i >> 1) != 0 ? part.y : 1.0 - part.y);
            vec2 before = imageLoad(sunBefore, tap).xy;
            old += w * before;
            weight += w;
        }
        old = weight > 1e-3 ? old / weight : vec2(0.0);
    }
    // While everything stands still, the mean is of all frames; a sun that has moved leaves little of it.
    float most = max(float(push.history), float(frame.still));
    if (state.changed != 0u) most = min(most, state.cap);
    float n = min(old.y, most) + 1.0;
    imageStore(outSun, pixel, vec4(old.x + (cosine - old.x) / n, n, 0.0, 0.0));
}
