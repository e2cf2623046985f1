// Keeps the cursor and the buttons of this frame for the next one.
#version 460
layout(local_size_x = 1) in;
layout(std430) writeonly buffer Last {
    ivec2 cursor;
    uint buttons;
} last;
layout(push_constant) uniform Push {
    ivec2 cursor;
    uint buttons;
};

void main() {
    last.cursor = cursor;
    last.buttons = buttons;
}
