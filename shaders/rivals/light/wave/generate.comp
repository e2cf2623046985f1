// A path for each pixel.
#version 460
#include "light/scene.glsl"
#include "wave.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(std430) writeonly buffer Queue { uint count; uint bins[WAVE_BINS]; } queue;
layout(std430) writeonly buffer Paths { Path paths[]; };
layout(std430) writeonly buffer Light { vec4 light[]; };
layout(push_constant) uniform Push { ivec2 size; } push;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, push.size))) return;
    uint id = uint(pixel.x + push.size.x * pixel.y);
    // The first rays are in order as they are: one bin.
    if (id == 0u) {
        queue.count = uint(push.size.x * push.size.y);
        queue.bins[0] = uint(push.size.x * push.size.y);
    }
    paths[id] = Path(frame.camera_cell, id, frame.camera_frac, 0.0, pixel_direction(pixel, push.size), 0u, vec3(1.0), 0u);
    light[id] = vec4(0.0);
}
