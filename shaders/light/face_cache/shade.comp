// Light of each pixel: the cached light of its face, sunlight by the pixel's own history, and its own emission.
#version 460
#include <raxel/scene.glsl>
#include "../scene.glsl"
#include "box.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba32i) uniform readonly iimage2D hits;
layout(rgba32f) uniform readonly image2D places;
layout(r32ui) uniform readonly uimage2D slots;
uniform sampler2D sun;
#ifdef PANES
uniform sampler2D stained;
#endif
layout(rgba32f) uniform writeonly image2D outRadiance;
layout(push_constant) uniform Push { bool smooth_faces; } push;
#define QUEUE_ACCESS
#include "queue.glsl"
#include "cache.glsl"
#include "across.glsl"
#include "cells.glsl"
#include "blend.glsl"

shared uint logs;
shared uint showing;

// The brightness of all decides how much the noise of cached light matters. One in 16 groups of pixels is asked.
void note_light(float light, bool shows) {
    if (any(notEqual(gl_WorkGroupID.xy & 3u, uvec2(0u)))) return;
    bool first = gl_LocalInvocationIndex == 0u;
    if (first) {
        logs = 0u;
        showing = 0u;
    }
    barrier();
    if (shows && light > 0.0) {
        atomicAdd(logs, uint(QUEUE_ONE * (clamp(log2(light), QUEUE_LOG_LEAST, QUEUE_LOG_MOST) - QUEUE_LOG_LEAST)));
        atomicAdd(showing, 1u);
    }
    barrier();
    if (first && showing > 0u) {
        atomicAdd(queue.logs, logs);
        atomicAdd(queue.showing, showing);
    }
}

float luminance(vec3 light) {
    return min(dot(light, vec3(0.2126, 0.7152, 0.0722)), 1e15);
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), size = imageSize(outRadiance);
    bool inside = all(lessThan(pixel, size));
    vec3 to_sun = frame_sun();
    ivec4 hit = inside ? imageLoad(hits, pixel) : ivec4(0, 0, 0, -1);
    vec3 color = vec3(0.0), kept = vec3(0.0), other = vec3(0.0);
    uint face = hit_face(hit.w);
    bool shows = hit.w >= 0 && face != RX_FACE_INSIDE;
    if (shows) {
        RxMaterial material = rx_material_properties(hit_material(hit.w));
        uint slot = imageLoad(slots, pixel).x;
        if (slot != RX_NO_FACE) {
            kept = push.smooth_faces ? blended(slot, hit.xyz, imageLoad(places, pixel).xy, float(size.y)) : light[slot].rgb;
            queue.pick[slot] = 0u;
        }
        vec3 sunlight = sun_irradiance(to_sun) * (texelFetch(sun, pixel, 0).x / RX_PI);
#ifdef PANES
        sunlight += sun_irradiance(to_sun) * texelFetch(stained, pixel, 0).rgb / RX_PI;
#endif
        if (sunlight != vec3(0.0)) sunlight *= sun_through_clouds(pixel_world(pixel, size, imageLoad(places, pixel).z));
        other = frame.lamp_strength * material.emission + sunlight;
        color = material.albedo * (kept + other);
    } else if (hit.w < 0) {
        color = sky_radiance(pixel_direction(pixel, size), to_sun);
    }
    if (inside) imageStore(outRadiance, pixel, vec4(color, 1.0));
    note_light(luminance(kept + other), shows);
}
