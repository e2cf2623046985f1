// Half the picture, and of it only what is bright.
#version 460
layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba16f) uniform readonly image2D picture;
layout(rgba16f) uniform writeonly image2D outGlow;

void main() {
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(texel, imageSize(outGlow)))) return;

    vec3 sum = vec3(0.0);
    for (int i = 0; i < 4; ++i) {
        ivec2 from = min(2 * texel + ivec2(i & 1, i >> 1), imageSize(picture) - 1);
        // Blue has to be brighter than the rest, so that the sky does not glow.
        sum += max(imageLoad(picture, from).rgb - vec3(0.6, 0.6, 0.85), 0.0);
    }
    imageStore(outGlow, texel, vec4(0.25 * sum, 1.0));
}
