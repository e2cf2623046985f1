// From linear light without bounds to linear display values in 0 to 1. All are monotonic for greys and take 0 to 0.
#ifndef RAXEL_TONE_GLSL
#define RAXEL_TONE_GLSL

const uint RX_TONE_NARKOWICZ = 0u;
const uint RX_TONE_REINHARD = 1u;
const uint RX_TONE_AGX = 2u;
const uint RX_TONE_NEUTRAL = 3u;

// Narkowicz, "ACES filmic tone mapping curve", 2015: high contrast, bright colours go to white late.
vec3 rx_tone_narkowicz(vec3 light) {
    return clamp(light * (2.51 * light + 0.03) / (light * (2.43 * light + 0.59) + 0.14), 0.0, 1.0);
}

// Reinhard's extended operator on luminance; light of `white` becomes white.
vec3 rx_tone_reinhard(vec3 light, float white) {
    float l = dot(light, vec3(0.2126, 0.7152, 0.0722));
    return clamp(light * ((1.0 + l / (white * white)) / (1.0 + l)), 0.0, 1.0);
}

// AgX by Troy Sobotka, in Benjamin Wrensch's polynomial: bright colours go to white softly. Its curve has a foot at 0 of -0.00232, which
// is clipped.
vec3 rx_tone_agx(vec3 light) {
    const mat3 inset = mat3(0.842479062253094, 0.0423282422610123, 0.0423756549057051, 0.0784335999999992, 0.878468636469772,
                            0.0784336, 0.0792237451477643, 0.0791661274605434, 0.879142973793104);
    const mat3 outset = mat3(1.19687900512017, -0.0528968517574562, -0.0529716355144438, -0.0980208811401368, 1.15190312990417,
                             -0.0980434501171241, -0.0990297440797205, -0.0989611768448433, 1.15107367264116);
    vec3 x = clamp((log2(max(inset * light, 1e-10)) + 12.47393) / 16.5, 0.0, 1.0);
    vec3 x2 = x * x, x4 = x2 * x2;
    vec3 curve = 15.5 * x4 * x2 - 40.14 * x4 * x + 31.96 * x4 - 6.868 * x2 * x + 0.4298 * x2 + 0.1191 * x - 0.00232;
    return pow(clamp(outset * curve, 0.0, 1.0), vec3(2.2));
}

// Khronos PBR Neutral: colours stay as they are up to 0.8 less the reflection of a coat, only highlights are compressed.
vec3 rx_tone_neutral(vec3 light) {
    const float start = 0.8 - 0.04, desaturation = 0.15;
    float low = min(light.x, min(light.y, light.z));
    light -= low < 0.08 ? low - 6.25 * low * low : 0.04;
    float peak = max(light.x, max(light.y, light.z));
    if (peak < start) return light;
    const float d = 1.0 - start;
    float compressed = 1.0 - d * d / (peak + d - start);
    light *= compressed / peak;
    return mix(vec3(compressed), light, 1.0 / (desaturation * (peak - compressed) + 1.0));
}

// The inverse of rx_tone_neutral for light that was not negative. Values below 1.
vec3 rx_tone_neutral_inverse(vec3 color) {
    const float start = 0.8 - 0.04, desaturation = 0.15, d = 1.0 - start;
    float peak = max(color.x, max(color.y, color.z));
    if (peak > start) {
        float before = d * d / (1.0 - peak) - d + start;
        float kept = 1.0 / (desaturation * (before - peak) + 1.0);
        color = ((color - peak) / kept + peak) * (before / peak);
    }
    float low = min(color.x, min(color.y, color.z));
    return color + (low > 0.04 ? 0.04 : sqrt(max(low, 0.0) / 6.25) - max(low, 0.0));
}

// Applies one of the curves RX_TONE_* to linear light. The result is linear, from 0 to 1.
vec3 rx_tone(vec3 light, uint curve) {
    if (curve == RX_TONE_NARKOWICZ) return rx_tone_narkowicz(light);
    if (curve == RX_TONE_REINHARD) return rx_tone_reinhard(light, 5.0);
    if (curve == RX_TONE_AGX) return rx_tone_agx(light);
    return rx_tone_neutral(light);
}

#endif
