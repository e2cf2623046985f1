#version 460
// Corners of the triangles of an overlay.

layout(location = 0) in vec2 position; // points from the top left
layout(location = 1) in vec2 uv;       // 0 to 1 from the top left of the texture
layout(location = 2) in vec4 color;    // sRGB-encoded, multiplied by alpha

layout(push_constant) uniform Picture {
    vec2 extent; // points
} picture;

layout(location = 0) out vec2 fragmentUv;
layout(location = 1) out vec4 fragmentColor;

void main() {
    gl_Position = vec4(2.0 * position / picture.extent - 1.0, 0.0, 1.0);
    fragmentUv = uv;
    fragmentColor = color;
}
