// A round of smoothing over 5 x 5 pixels. The holes between them double with each round (Dammertz et al., "Edge-avoiding a-trous wavelet
// transform", 2010; Schied et al., "Spatiotemporal variance-guided filtering", 2017). Only pixels of the same plane are mixed.
#version 460
#include <raxel/ray.glsl>

layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba32i) uniform readonly iimage2D hits;
layout(rgba32f) uniform readonly image2D light;
layout(rgba32f) uniform writeonly image2D outLight;
layout(push_constant) uniform Push { uint round; float sigma; } push;

float luminance(vec3 l) {
    return dot(l, vec3(0.2126, 0.7152, 0.0722));
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), size = imageSize(outLight);
    if (any(greaterThanEqual(pixel, size))) return;
    ivec4 hit = imageLoad(hits, pixel);
    vec4 own = imageLoad(light, pixel);
    uint face = uint(hit.w) >> 16 & 7u, axis = rx_face_axis(face);
    vec4 sum = own * vec4(vec3(0.140625), 0.140625 * 0.140625);
    float weight = 0.140625;
    if (hit.w >= 0 && face != RX_FACE_INSIDE) {
        const float kernel[3] = float[](0.375, 0.25, 0.0625);
        float allowed = push.sigma * sqrt(max(own.w, 0.0)) + 1e-4;
        for (int i = 0; i < 25; ++i) {
            ivec2 step = ivec2(i % 5, i / 5) - 2, tap = pixel + (step << push.round);
            if (step == ivec2(0) || any(lessThan(tap, ivec2(0))) || any(greaterThanEqual(tap, size))) continue;
            ivec4 there = imageLoad(hits, tap);
            if (there.w < 0 || (uint(there.w) >> 16 & 7u) != face || there[axis] != hit[axis]) continue;
            vec4 other = imageLoad(light, tap);
            float w = kernel[abs(step.x)] * kernel[abs(step.y)] * exp(-abs(luminance(other.rgb) - luminance(own.rgb)) / allowed);
            sum += vec4(w * other.rgb, w * w * other.w);
            weight += w;
        }
    }
    imageStore(outLight, pixel, vec4(sum.rgb / weight, sum.w / (weight * weight)));
}
