// Discs on a grid, whose size breathes. Stores only the texels inside them.
#version 460
layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba16f) uniform writeonly image2D outColor;
layout(push_constant) uniform Push { float time; };   // seconds

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    ivec2 size = imageSize(outColor);
    if (any(greaterThanEqual(pixel, size))) return;
    vec2 at = (vec2(pixel) + 0.5) / float(size.y) * 5.0;
    vec2 cell = floor(at);
    float radius = 0.28 + 0.12 * sin(2.0 * time + cell.x + 2.0 * cell.y);
    if (distance(fract(at), vec2(0.5)) > radius) return;
    imageStore(outColor, pixel, vec4(0.95, 0.93, 0.85, 1.0));
}
