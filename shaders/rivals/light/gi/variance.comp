// The input of smoothing: the mean light and the variance of its luminance. After few frames the variance is unknown, so the filter smooths
// much. A pixel whose paths found little light underestimates its variance, and would stay dark beside bright pixels. So the variance is that of
// 3 x 3 pixels of the plane (Schied et al., "Spatiotemporal variance-guided filtering", 2017, section 4.3).
#version 460
#include <raxel/ray.glsl>

layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba32i) uniform readonly iimage2D hits;
layout(rgba32f) uniform readonly image2D mean;       // light, frames
layout(rg32f) uniform readonly image2D moments;      // mean and mean square of luminance
layout(rgba32f) uniform writeonly image2D outLight;

// Variance of a pixel's mean by its own samples.
float seen(ivec2 pixel, float frames) {
    vec2 m = imageLoad(moments, pixel).xy;
    return frames < 4.0 ? m.y + 1e-4 : max(m.y - m.x * m.x, 0.0) / frames;
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), size = imageSize(outLight);
    if (any(greaterThanEqual(pixel, size))) return;
    vec4 light = imageLoad(mean, pixel);
    ivec4 hit = imageLoad(hits, pixel);
    uint face = uint(hit.w) >> 16 & 7u, axis = rx_face_axis(face);
    float sum = 4.0 * seen(pixel, light.w), weight = 4.0;
    for (int i = 0; i < 9 && hit.w >= 0 && face != RX_FACE_INSIDE; ++i) {
        ivec2 step = ivec2(i % 3, i / 3) - 1, tap = pixel + step;
        if (i == 4 || any(lessThan(tap, ivec2(0))) || any(greaterThanEqual(tap, size))) continue;
        ivec4 there = imageLoad(hits, tap);
        if (there.w < 0 || (uint(there.w) >> 16 & 7u) != face || there[axis] != hit[axis]) continue;
        float w = float((2 - abs(step.x)) * (2 - abs(step.y)));
        sum += w * seen(tap, imageLoad(mean, tap).w);
        weight += w;
    }
    imageStore(outLight, pixel, vec4(light.rgb, sum / weight));
}
