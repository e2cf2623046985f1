// A round brush on a path that never closes. Stores only the texels that it touches.
#version 460
layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba16f) uniform writeonly image2D canvas;
layout(push_constant) uniform Push {
    float time;     // seconds
    float radius;   // of the brush, as a part of the height
};

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    ivec2 size = imageSize(canvas);
    if (any(greaterThanEqual(pixel, size))) return;
    vec2 at = (vec2(pixel) + 0.5 - 0.5 * vec2(size)) / float(size.y);
    vec2 brush = 0.38 * vec2(sin(1.3 * time) + 0.5 * sin(4.1 * time), cos(1.9 * time));
    if (distance(at, brush) > radius) return;
    imageStore(canvas, pixel, vec4(0.5 + 0.5 * cos(vec3(0.0, 2.1, 4.2) + 0.7 * time), 1.0));
}
