// What each pixel sees, and a list of the faces that get new samples, each once: all that are new, and of the others as many as there are
// paths for, in turn. Faces that know their light well take their turn less often.
#version 460
#include <raxel/world.glsl>
#include "../scene.glsl"
#include "box.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba32i) uniform writeonly iimage2D outHit;
layout(rgba32f) uniform writeonly image2D outPlace;
layout(r32ui) uniform writeonly uimage2D outSlot;
layout(std430) buffer FaceKeys { uint face_keys[]; };
layout(std430) buffer Asked { uint asked[]; };
#define QUEUE_ACCESS
#include "queue.glsl"
#include "../change.glsl"
layout(std430) readonly buffer Light { vec4 light[]; };
layout(std430) readonly buffer Generation { uint generation[]; };
layout(std430) writeonly buffer Faces { uint faces[]; };
layout(push_constant) uniform Push { float quarters; int settled; int rarely; } push;
#define RX_FACE_INSERT
#include <raxel/light/face_table.glsl>
#include "across.glsl"

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), size = imageSize(outHit);
    if (any(greaterThanEqual(pixel, size))) return;
    RxRay ray = rx_ray(frame.camera_cell, frame.camera_frac, pixel_direction(pixel, size));
    RxHit hit;
    bool found = rx_trace(ray, hit);
    imageStore(outHit, pixel, found ? ivec4(hit.voxel, pack_hit(hit.material, hit.face)) : ivec4(0, 0, 0, -1));
    imageStore(outPlace, pixel, found ? vec4(hit.uv, hit.t, 0.0) : vec4(0.0));
    uint slot = RX_NO_FACE;
    if (found && hit.face != RX_FACE_INSIDE && rx_face_fits(hit.voxel, face_box())) {
        uint part = pixels_across(hit.voxel, hit.face, float(size.y)) < push.quarters ? 0u : rx_face_quarter(hit.uv);
        RxFaceKey key = rx_face_key(hit.voxel, hit.face, part);
        slot = rx_face_insert(key);
        // Frames count from 1 here: 0 is a slot that nobody has asked for. The list holds as many faces as there are pixels.
        uint now = frame.index + 1u;
        if (slot != RX_NO_FACE && asked[slot] != now && atomicExchange(asked[slot], now) != now) {
            atomicAdd(queue.seen, 1u);
            // Samples of light that is gone do not count.
            float samples = generation[slot] == state.generation ? light[slot].w : 0.0;
            uint wait = max(queue.every, 1u) * uint(clamp(samples / float(max(push.settled, 1)), 1.0, float(max(push.rarely, 1))));
            // By the key, because slots depend on the order of threads.
            bool turn = (rx_hash(key.home ^ key.rest) + frame.index) % wait == 0u;
            if (turn || samples == 0.0) faces[atomicAdd(queue.count, 1u)] = slot;
        }
    }
    imageStore(outSlot, pixel, uvec4(slot));
}
