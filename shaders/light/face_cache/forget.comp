// Empties the list of faces, decides how many of those in sight are listed, says how noisy a sample is, and gives slots back whose faces nobody has asked for in a long time: a 256th of the table in each frame.
#version 460
#include "../scene.glsl"

layout(local_size_x = 64) in;
layout(std430) buffer FaceKeys { uint face_keys[]; };
layout(std430) readonly buffer Asked { uint asked[]; };
#define QUEUE_ACCESS
#include "queue.glsl"
layout(std430) writeonly buffer Light { vec4 light[]; };
layout(push_constant) uniform Push { uint pixels; float paths; } push;
#include <raxel/light/face_table.glsl>

const uint AGE = 600u;  // frames

void main() {
    if (gl_GlobalInvocationID.x == 0u) {
        // As many faces are in sight as in the last frame, about.
        float budget = max(push.paths * float(push.pixels), 1.0);
        queue.every = uint(clamp(ceil(float(queue.seen) / budget), 1.0, 16.0));
        queue.seen = 0u;
        queue.count = 0u;
        queue.lost = 0u;
        // One number for all faces: a number of samples that follows each face's own samples would stop where they happen to lie low.
        if (queue.spreads >= 16u) {
            float noise = float(queue.spread) / (QUEUE_ONE * float(queue.spreads));
            queue.noise += (noise - queue.noise) * (queue.noise > 0.0 ? 0.1 : 1.0);
        }
        if (queue.showing > 0u) queue.bright = exp2(float(queue.logs) / (QUEUE_ONE * float(queue.showing)) + QUEUE_LOG_LEAST);
        queue.spread = 0u;
        queue.spreads = 0u;
        queue.logs = 0u;
        queue.showing = 0u;
    }
    uint slot = (frame.index & 255u) * (RX_FACE_SLOTS >> 8) + gl_GlobalInvocationID.x;
    if (face_keys[slot] >> 31 == 0u || frame.index + 1u - asked[slot] < AGE) return;
    face_keys[slot] = RX_FACE_FREED;
    light[slot] = vec4(0.0);
}
