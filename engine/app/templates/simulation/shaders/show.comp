// The amount of the second chemical as a colour, lit from the side.
#version 460
layout(local_size_x = 8, local_size_y = 8) in;
uniform sampler2D chemicals;
layout(rgba16f) uniform writeonly image2D outColor;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    ivec2 size = imageSize(outColor);
    if (any(greaterThanEqual(pixel, size))) return;

    vec2 uv = (vec2(pixel) + 0.5) / vec2(size);
    vec2 texel = 1.0 / vec2(textureSize(chemicals, 0));
    float here = textureLod(chemicals, uv, 0.0).y;
    vec2 slope = here - vec2(textureLod(chemicals, uv + vec2(texel.x, 0.0), 0.0).y, textureLod(chemicals, uv + vec2(0.0, texel.y), 0.0).y);
    float light = clamp(0.75 + 6.0 * dot(slope, vec2(-0.7, -0.7)), 0.2, 1.6);
    vec3 color = mix(vec3(0.01, 0.03, 0.06), vec3(0.95, 0.45, 0.12), smoothstep(0.05, 0.35, here));
    imageStore(outColor, pixel, vec4(color * light, 1.0));
}
