#version 460
// The left stick moves the pen, and each shoulder takes another colour.
layout(local_size_x = 1) in;
buffer Pen { vec2 place; float hue; float unused; } pen;   // place: -1 to 1 on the shorter side, y up
layout(push_constant) uniform Push {
    vec4 sticks;
    float delta;    // seconds
    uint pressed;
};

const uint LEFT_SHOULDER = 1u << 4;
const uint RIGHT_SHOULDER = 1u << 5;

void main() {
    pen.place = clamp(pen.place + 1.5 * delta * sticks.xy, vec2(-1.0), vec2(1.0));
    if ((pressed & LEFT_SHOULDER) != 0) pen.hue -= 0.15;
    if ((pressed & RIGHT_SHOULDER) != 0) pen.hue += 0.15;
}
