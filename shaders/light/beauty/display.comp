// Maps light to display values: sharpening, bloom, exposure, tone curve, contrast and colour. Noise of less than one step of the screen hides bands.
#version 460
#include <raxel/tone.glsl>
#include <raxel/random.glsl>

layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba32f) uniform readonly image2D radiance;   // light, frames in the mean
uniform sampler2D bloom;
layout(std430) readonly buffer Eye { float eye_exposure; };
layout(rgba16f) uniform writeonly image2D outColor;
layout(push_constant) uniform Push { float exposure; float bloom_share; uint tone; float sharpness; float contrast; float saturation; } push;

// 0 to 1, where the exposure maps a bright surface to 1/2: ringing around the sun stays small.
vec3 pressed(vec3 light, float exposure) {
    light *= exposure;
    return light / (1.0 + light);
}

// The light of a pixel against that of its four neighbours: the more, the less contrast there is around it (Lottes, "FidelityFX CAS", 2019).
vec3 sharpened(ivec2 pixel, ivec2 size, float exposure) {
    vec4 mean = imageLoad(radiance, pixel);
    vec3 light = mean.rgb;
    if (push.sharpness <= 0.0) return light;
    vec3 middle = pressed(light, exposure), sum = vec3(0.0), low = middle, high = middle;
    for (int i = 0; i < 4; ++i) {
        ivec2 step = (i & 1) == 0 ? ivec2(i - 1, 0) : ivec2(0, i - 2);
        vec3 beside = pressed(imageLoad(radiance, clamp(pixel + step, ivec2(0), size - 1)).rgb, exposure);
        sum += beside;
        low = min(low, beside);
        high = max(high, beside);
    }
    vec3 room = sqrt(clamp(min(low, 1.0 - high) / max(high, 1e-4), 0.0, 1.0));
    // The mean of few frames has noise, which is not sharpened.
    vec3 weight = -0.2 * push.sharpness * mean.a / (mean.a + 2.0) * room;
    // No further than a quarter beyond its neighbours, so that no bright line lies along a dark edge.
    vec3 beyond = 0.25 * (high - low);
    vec3 sharp = clamp((middle + weight * sum) / (1.0 + 4.0 * weight), max(low - beyond, 0.0), high + beyond);
    return sharp / max(1.0 - sharp, 1e-5) / exposure;
}

// An S through 0, mid-grey and 1.
vec3 contrasted(vec3 color, float contrast) {
    const float grey = 0.2;
    vec3 low = pow(color, vec3(contrast)), high = pow(1.0 - color, vec3(contrast));
    return low / (low + pow(grey / (1.0 - grey), contrast - 1.0) * high);
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), size = imageSize(outColor);
    if (any(greaterThanEqual(pixel, size))) return;
    float exposure = push.exposure * eye_exposure;
    vec3 light = exposure > 0.0 ? sharpened(pixel, size, exposure) : vec3(0.0);
    light = mix(light, textureLod(bloom, (vec2(pixel) + 0.5) / vec2(size), 0.0).rgb, push.bloom_share);
    vec3 color = clamp(rx_tone(exposure * light, push.tone), 0.0, 1.0);
    color = contrasted(color, push.contrast);
    color = max(mix(vec3(dot(color, vec3(0.2126, 0.7152, 0.0722))), color, push.saturation), 0.0);
    // A step of 8 bits is about 1 / 255 of the encoded value; the slope of the encoding is taken into account roughly.
    uint seed = rx_hash(ivec3(pixel, 0));
    color += (rx_random(seed) - 0.5) / 255.0 * 2.0 * sqrt(max(color, vec3(1e-4)));
    imageStore(outColor, pixel, vec4(clamp(color, 0.0, 1.0), 1.0));
}
