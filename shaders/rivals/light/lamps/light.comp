// Light of the lamps on each pixel. The pixel chooses a point from its own point and those of some neighbours, and one ray tests whether that point is hidden.
#version 460
#include <raxel/world.glsl>
#include "light/scene.glsl"
#include <raxel/light/reservoir.glsl>

layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba32i) uniform readonly iimage2D hits;
layout(rgba32f) uniform readonly image2D places;
layout(rgba32ui) uniform readonly uimage2D chosen;
layout(rgba32ui) uniform writeonly uimage2D outBefore;
layout(rgba32f) uniform image2D path;               // all other light that falls on the pixel, / pi
layout(push_constant) uniform Push { int neighbours; float radius; bool unbiased; int candidates; } push;

const uint MOST = 8u;  // neighbours

// The start of a ray that leaves the face of a pixel.
RxRay from_pixel(ivec2 pixel, ivec4 hit) {
    return rx_ray_from_face(hit.xyz, hit_face(hit.w), imageLoad(places, pixel).xy, rx_normal(hit_face(hit.w)));
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), size = imageSize(path);
    if (any(greaterThanEqual(pixel, size))) return;
    ivec4 hit = imageLoad(hits, pixel);
    RxReservoir own = rx_unpack_reservoir(imageLoad(chosen, pixel));
    imageStore(outBefore, pixel, rx_pack_reservoir(own));
    if (hit.w < 0 || hit_face(hit.w) == RX_FACE_INSIDE || rx_lights_count() == 0u) return;
    vec3 normal = rx_normal(hit_face(hit.w));
    RxRay from = from_pixel(pixel, hit);
    float points = float(push.candidates);
    RxSampler numbers = rx_sampler(frame.index, scene_seed(uint(pixel.x) + rx_hash(uint(pixel.y) + 31u)));
    float keep = rx_next(numbers), sum = 0.0;

    // Pixels of the same plane around, whose points are likely to be good here.
    ivec2 taps[MOST];
    uint count = 0u, from_tap = 0u, most = min(uint(push.neighbours), MOST);
    RxReservoir best = own;
    rx_takes(rx_reservoir_target(own, from, normal, points) * own.weight * own.count, sum, keep);
    float all = own.count;
    uint axis = rx_face_axis(hit_face(hit.w));
    for (uint i = 0u; i < most; ++i) {
        vec2 u = rx_next2(numbers);
        float r = push.radius * sqrt(u.x), a = 2.0 * RX_PI * u.y;
        ivec2 tap = pixel + ivec2(round(r * vec2(cos(a), sin(a))));
        if (tap == pixel || any(lessThan(tap, ivec2(0))) || any(greaterThanEqual(tap, size))) continue;
        ivec4 there = imageLoad(hits, tap);
        if (there.w < 0 || hit_face(there.w) != hit_face(hit.w) || there[axis] != hit[axis]) continue;
        RxReservoir other = rx_unpack_reservoir(imageLoad(chosen, tap));
        taps[count++] = tap;
        all += other.count;
        if (rx_takes(rx_reservoir_target(other, from, normal, points) * other.weight * other.count, sum, keep)) {
            best = other;
            from_tap = count;
        }
    }

    RxLampSample light = rx_reservoir_light(best, from, normal, points);
    float target = rx_luminance(light.light);
    if (!(sum > 0.0 && target > 0.0)) return;
    float share = 1.0 / all;
    if (push.unbiased) {
        // A point counts only for the pixels that could have chosen it (Bitterli and others, section 4.3), and more for pixels where it matters:
        // the balance heuristic over all pixels that took part.
        float mine = rx_reservoir_target(best, from, normal, points), each = own.count * mine, source = mine;
        for (uint i = 0u; i < count; ++i) {
            float theirs = rx_reservoir_target(best, from_pixel(taps[i], imageLoad(hits, taps[i])), normal, points);
            each += rx_unpack_reservoir(imageLoad(chosen, taps[i])).count * theirs;
            if (i + 1u == from_tap) source = theirs;
        }
        share = each > 0.0 ? source / each : 0.0;
    }
    RxHit block;
    if (share == 0.0 || rx_trace(rx_lamp_ray(from, light.to), block)) return;
    vec4 other = imageLoad(path, pixel);
    imageStore(path, pixel, vec4(other.rgb + frame.lamp_strength * light.light * (sum * share / target), other.a));
}
