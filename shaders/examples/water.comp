// A height field seen from above: light from the slope, colour from the height.
#version 460
layout(local_size_x = 8, local_size_y = 8) in;
uniform sampler2D height;
layout(rgba8) uniform writeonly image2D outColor;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    ivec2 size = imageSize(outColor);
    if (any(greaterThanEqual(pixel, size))) return;
    vec2 uv = (vec2(pixel) + 0.5) / vec2(size);
    vec2 texel = 1.0 / vec2(textureSize(height, 0));
    float here = textureLod(height, uv, 0.0).x;
    vec2 slope = vec2(textureLod(height, uv + vec2(texel.x, 0.0), 0.0).x, textureLod(height, uv + vec2(0.0, texel.y), 0.0).x) - here;
    vec3 normal = normalize(vec3(-4.0 * slope, 1.0));
    float light = max(dot(normal, normalize(vec3(-0.5, -0.6, 0.7))), 0.0);
    vec3 color = mix(vec3(0.02, 0.10, 0.22), vec3(0.25, 0.62, 0.70), clamp(0.5 + here, 0.0, 1.0));
    imageStore(outColor, pixel, vec4(color * (0.35 + 0.9 * light) + pow(light, 40.0) * 0.6, 1.0));
}
