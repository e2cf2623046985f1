// The shown light of a face: its own, blended with that of its neighbours as far as noise requires it (soften.comp). Three mantissas of 18
// bits under one exponent, in 8 bytes.

const float SOFT_ONE = 262143.0;

uvec2 soft_pack(vec3 light) {
    light = max(light, vec3(0.0));
    float most = max(max(light.r, max(light.g, light.b)), 1e-30);
    int exponent;
    frexp(most, exponent);
    uvec3 m = uvec3(light * (ldexp(1.0, -exponent) * SOFT_ONE) + 0.5);
    return uvec2(m.r | m.g << 18, m.g >> 14 | m.b << 4 | uint(exponent + 128) << 22);
}

vec3 soft_unpack(uvec2 word) {
    uvec3 m = uvec3(word.x & 0x3ffffu, word.x >> 18 | (word.y & 15u) << 14, word.y >> 4 & 0x3ffffu);
    return vec3(m) * (ldexp(1.0, int(word.y >> 22) - 128) / SOFT_ONE);
}
