// Noise of faces that have few samples is shared with the faces around them. Neighbours of one plane count by the number of their samples, as far
// as chance explains the difference between the two: the more samples both have, the smaller a difference must be, so that with time
// each face shows what it has itself, and edges of shadows stay where they are.
#version 460
#include <raxel/world.glsl>
#include <raxel/thread.glsl>
#include "../scene.glsl"
#include "box.glsl"

layout(local_size_x = 64) in;
layout(std430) readonly buffer FaceKeys { uint face_keys[]; };
layout(std430) readonly buffer Asked { uint asked[]; };
#include "queue.glsl"
#include "../change.glsl"
layout(std430) readonly buffer Faces { uint faces[]; };
layout(std430) readonly buffer Light { vec4 light[]; };
layout(std430) readonly buffer Generation { uint generation[]; };
layout(std430) readonly buffer Squares { float squares[]; };
layout(std430) writeonly buffer Soft { uvec2 soft[]; };
#include <raxel/light/face_table.glsl>
#include "soft.glsl"
#include "beside.glsl"

const float APART = 1.5;    // standard errors between two faces that count as alike
const uint RECENT = 16u;    // frames since a neighbour was seen
const float CLEAN = 0.02;   // standard error, as a share of the mean, from which on a face needs no neighbours

float luminance(vec3 light) {
    return dot(light, vec3(0.2126, 0.7152, 0.0722));
}

// A neighbour with light of now, or RX_NO_FACE. Its light is of the world of now, too, so it is still bare if it was not seen in this very frame, as
// faces that are smaller than pixels are not.
uint lit_beside(ivec3 voxel, uint face, uint part, ivec2 step) {
    uint slot = seen_beside(voxel, face, part, step, RECENT);
    return slot != RX_NO_FACE && generation[slot] == state.generation && light[slot].w > 0.0 ? slot : RX_NO_FACE;
}

void add(uint slot, vec4 own, float variance, inout vec3 sum, inout float samples) {
    vec4 other = light[slot];
    float away = luminance(other.rgb) - luminance(own.rgb);
    float share = other.w * exp(-away * away / max(APART * APART * variance * (1.0 / own.w + 1.0 / other.w), 1e-30));
    sum += share * other.rgb;
    samples += share;
}

void main() {
    uint i = rx_thread();
    if (i >= queue.count) return;
    uint slot = faces[i];
    RxFaceKey key;
    if (!rx_face_in_slot(slot, key)) return;
    vec4 own = light[slot];
    vec3 result = own.rgb;
    float mean = luminance(own.rgb), square = squares[slot];
    // Few samples know little of their variance.
    if (own.w < 64.0 || square - mean * mean > CLEAN * CLEAN * own.w * mean * mean) {
        ivec3 voxel;
        uint face, part;
        rx_face_of(key, face_box(), voxel, face, part);
        // Eight neighbours, row by row with the face itself in the middle; the variance is that of all of them together.
        uint near[9];
        float samples = own.w;
        mean *= own.w;
        square *= own.w;
        for (int k = 0; k < 9; ++k) {
            near[k] = k == 4 ? slot : lit_beside(voxel, face, part, ivec2(k % 3, k / 3) - 1);
            if (k == 4 || near[k] == RX_NO_FACE) continue;
            mean += light[near[k]].w * luminance(light[near[k]].rgb);
            square += light[near[k]].w * squares[near[k]];
            samples += light[near[k]].w;
        }
        mean /= samples;
        float variance = max(square / samples - mean * mean, 0.0);
        vec3 sum = own.w * own.rgb;
        samples = own.w;
        int beside = 0;
        for (int k = 0; k < 9; ++k) {
            // Around a corner only by one of the faces beside it: between two that touch there may be a wall.
            if (k % 2 == 0 && near[k % 3 == 0 ? 3 : 5] == RX_NO_FACE && near[k < 3 ? 1 : 7] == RX_NO_FACE) near[k] = RX_NO_FACE;
            if (k == 4 || near[k] == RX_NO_FACE) continue;
            add(near[k], own, variance, sum, samples);
            ++beside;
        }
        // Straight on, each by the one before it, where there is still noise: one more, or three on a narrow strip.
        if (variance > CLEAN * CLEAN * samples * mean * mean) {
            int most = beside > 5 ? 2 : 4;
            for (int k = 1; k < 9; k += 2) {
                uint last = near[k];
                for (int far = 2; far <= most && last != RX_NO_FACE; ++far) {
                    last = lit_beside(voxel, face, part, far * (ivec2(k % 3, k / 3) - 1));
                    if (last != RX_NO_FACE) add(last, own, variance, sum, samples);
                }
            }
        }
        if (samples > 0.0) result = sum / samples;
    }
    soft[slot] = soft_pack(result);
}
