#version 460
layout(local_size_x = 8, local_size_y = 8) in;
layout(std430) readonly buffer Light { vec4 light[]; };
layout(rgba32f) uniform image2D sum;
layout(rgba16f) uniform writeonly image2D outColor;
layout(push_constant) uniform Push { float exposure; uint still; } push;
void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), size = imageSize(outColor);
    if (any(greaterThanEqual(pixel, size))) return;
    vec3 now = min(light[pixel.x + size.x * pixel.y].rgb, vec3(20.0));
    vec4 all = vec4(now, 1.0) + (push.still == 0u ? vec4(0.0) : imageLoad(sum, pixel));
    imageStore(sum, pixel, all);
    vec3 l = push.exposure * all.rgb / all.w;
    imageStore(outColor, pixel, vec4(clamp(l * (2.51 * l + 0.03) / (l * (2.43 * l + 0.59) + 0.14), 0.0, 1.0), 1.0));
}
