#version 460
// A round pen, as wide as the right trigger is pressed. South wipes.
layout(local_size_x = 8, local_size_y = 8) in;
readonly buffer Pen { vec2 place; float hue; float unused; } pen;
layout(rgba16f) uniform image2D canvas;
layout(push_constant) uniform Push {
    vec2 triggers;
    uint buttons;
};

const uint SOUTH = 1u;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    ivec2 size = imageSize(canvas);
    if (any(greaterThanEqual(pixel, size))) return;
    if ((buttons & SOUTH) != 0) {
        imageStore(canvas, pixel, vec4(0.05, 0.06, 0.09, 1.0));
        return;
    }
    float side = float(min(size.x, size.y));
    vec2 at = (2.0 * vec2(pixel.x + 0.5, size.y - pixel.y - 0.5) - vec2(size)) / side;
    float radius = 0.12 * triggers.y;
    float inside = clamp((radius - distance(at, pen.place)) * side * 0.5 + 0.5, 0.0, 1.0);
    if (triggers.y == 0.0 || inside == 0.0) return;
    vec3 color = 0.55 + 0.4 * cos(6.2832 * (pen.hue + vec3(0.0, 0.33, 0.67)));
    imageStore(canvas, pixel, mix(imageLoad(canvas, pixel), vec4(color, 1.0), inside));
}
