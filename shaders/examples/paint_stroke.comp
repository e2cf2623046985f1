// A stroke from the cursor of the frame before to the cursor. Stores only the texels that it touches.
#version 460
#include <raxel/keys.glsl>
layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba16f) uniform writeonly image2D canvas;
layout(std430) readonly buffer Last {
    ivec2 cursor;
    uint buttons;
} last;
layout(push_constant) uniform Push {
    ivec2 cursor;   // pixels; (-1, -1) without a cursor
    vec2 wheel;     // lines
    uint buttons;   // bit 0 is the left one
    float time;     // seconds
};

const vec3 PAPER = vec3(0.93, 0.91, 0.86);

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    ivec2 size = imageSize(canvas);
    if (any(greaterThanEqual(pixel, size))) return;
    if (rx_key(RX_KEY_BACKSPACE)) {
        imageStore(canvas, pixel, vec4(PAPER, 1.0));
        return;
    }
    if ((buttons & 1u) == 0u || cursor.x < 0) return;
    bool began = (last.buttons & 1u) == 0u || last.cursor.x < 0;
    vec2 from = vec2(began ? cursor : last.cursor), way = vec2(cursor) - from;
    float part = clamp(dot(vec2(pixel) - from, way) / max(dot(way, way), 1e-6), 0.0, 1.0);
    float radius = 0.03 * float(size.y) * exp2(0.2 * clamp(wheel.y, -10.0, 10.0));
    if (distance(vec2(pixel), from + part * way) > radius) return;
    vec3 ink = 0.5 + 0.4 * cos(vec3(0.0, 2.1, 4.2) + time);
    imageStore(canvas, pixel, vec4(rx_key(RX_KEY_SHIFT_LEFT) ? PAPER : ink, 1.0));
}
