// Light to display values: bloom, exposure, tone curve, and noise of less than one step of the screen in place of bands.
#version 460
#include <raxel/tone.glsl>
#include <raxel/random.glsl>

layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba32f) uniform readonly image2D radiance;
uniform sampler2D bloom;
layout(std430) readonly buffer Eye { float eye_exposure; };
layout(rgba16f) uniform writeonly image2D outColor;
layout(push_constant) uniform Push { float exposure; float bloom_share; uint tone; } push;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), size = imageSize(outColor);
    if (any(greaterThanEqual(pixel, size))) return;
    vec3 light = imageLoad(radiance, pixel).rgb;
    light = mix(light, textureLod(bloom, (vec2(pixel) + 0.5) / vec2(size), 0.0).rgb, push.bloom_share);
    vec3 color = rx_tone(push.exposure * eye_exposure * light, push.tone);
    // AgX leaves the look to who uses it: a little more contrast and colour.
    if (push.tone == RX_TONE_AGX) {
        color = pow(color, vec3(1.18));
        color = max(mix(vec3(dot(color, vec3(0.2126, 0.7152, 0.0722))), color, 1.25), 0.0);
    }
    // A step of 8 bits is about 1 / 255 of the encoded value; the slope of the encoding is taken into account roughly.
    uint seed = rx_hash(ivec3(pixel, 0));
    color += (rx_random(seed) - 0.5) / 255.0 * 2.0 * sqrt(max(color, vec3(1e-4)));
    imageStore(outColor, pixel, vec4(clamp(color, 0.0, 1.0), 1.0));
}
