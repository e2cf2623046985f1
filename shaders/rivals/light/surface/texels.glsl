// Light on a 16th of a face, in 8 bits a channel up to 4. Brighter light is clipped, and values between two steps are rounded down.
layout(std430) TEXEL_ACCESS buffer Texels { uint texels[]; };

const float TEXEL_MOST = 4.0;

uint texel_of(uint slot, vec2 uv) {
    uvec2 at = min(uvec2(uv * 4.0), uvec2(3u));
    return 16u * slot + at.x + 4u * at.y;
}

vec3 unpack_texel(uint word) {
    return unpackUnorm4x8(word).rgb * TEXEL_MOST;
}

uint pack_texel(vec3 light) {
    uvec3 bits = uvec3(clamp(light / TEXEL_MOST, 0.0, 1.0) * 255.0);
    return bits.x | bits.y << 8 | bits.z << 16 | 0xff000000u;
}
