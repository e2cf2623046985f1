// What smoothing begins with: the mean light and the variance of its luminance. With few frames nothing is known of that, and much is smoothed.
#version 460
layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba32f) uniform readonly image2D mean;       // light, frames
layout(rg32f) uniform readonly image2D moments;      // mean and mean square of luminance
layout(rgba32f) uniform writeonly image2D outLight;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, imageSize(outLight)))) return;
    vec4 light = imageLoad(mean, pixel);
    vec2 m = imageLoad(moments, pixel).xy;
    imageStore(outLight, pixel, vec4(light.rgb, light.w < 4.0 ? m.y + 1e-4 : max(m.y - m.x * m.x, 0.0) / light.w));
}
