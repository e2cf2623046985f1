// Shares the noise of faces with few samples with the faces around them. A neighbour on the same plane counts by its samples, as far as
// chance explains the difference between the two faces. The more samples both have, the smaller a difference must be. So each face shows its
// own light in time, and edges of shadows stay in place.
#version 460
#extension GL_EXT_control_flow_attributes : require
#include <raxel/scene.glsl>
#include <raxel/thread.glsl>
#include "../scene.glsl"
#include "box.glsl"

// Standard errors between two faces that count as alike.
#ifndef APART
#define APART 1.5
#endif

layout(local_size_x = 64) in;
#include "queue.glsl"
#include "../change.glsl"
#define SOFT_ACCESS writeonly
#include "cache.glsl"
layout(push_constant) uniform Push { ivec2 pixels; } push;
#include "soft.glsl"
#include "across.glsl"
#include "cells.glsl"
#include "beside.glsl"

const uint RECENT = 16u;    // frames since a neighbour was seen
const float FEW = 64.0;      // samples below which a face narrower than a pixel shares noise, too: a picture of few frames shows it as specks
const float QUIET = 0.25;    // noise of samples below which sunlight hides most of it
const float CLEAN = 0.02;    // a face needs no neighbours at this standard error, as a share of the mean
const float HIDDEN = 0.035;  // the same in quiet light, as a share of the light shown there

float luminance(vec3 light) {
    return dot(light, vec3(0.2126, 0.7152, 0.0722));
}

// Whether `samples` are too few for a variance.
bool noisy(float variance, float samples, float mean) {
    float enough = queue.noise < QUIET ? HIDDEN * HIDDEN * (mean * mean + queue.bright * queue.bright) : CLEAN * CLEAN * mean * mean;
    return variance > enough * samples;
}

// Neighbours of a face on its plane: the eight next to it, row by row, or the four at the distance `far` straight on.
const int RING = 8;
ivec2 ring_step(int far, int k) {
    int next = far > 1 ? 2 * (k % 4) + 1 : k < 4 ? k : k + 1;
    return (ivec2(next % 3, next / 3) - 1) * far;
}

// RX_NO_FACE if no face is seen there, or if its light is from before the last change of the world. Current light shows that the face is still bare,
// even if this frame missed it: frames miss faces that are smaller than pixels.
uint ring_slot[RING];
vec4 ring_light[RING];
float ring_square[RING];

// Looks for all whose bit is set in `wanted`. Step by step for all of them at once, so that they wait for memory together.
void look(uint own, ivec3 cell, uint face, uint part, int far, uint wanted) {
    RxFaceKey keys[RING];
    uint words[RING], seen[RING], made[RING];
    [[unroll]] for (int k = 0; k < RING; ++k) {
        bool fits = key_beside(cell, face, part, ring_step(far, k), keys[k]);
        words[k] = fits && (wanted >> k & 1u) != 0u ? face_keys[rx_face_slot(keys[k], 0u)] : 0u;
    }
    [[unroll]] for (int k = 0; k < RING; ++k) {
        bool first = words[k] == rx_face_word(keys[k], 0u);
        ring_slot[k] = words[k] == 0u ? RX_NO_FACE : first ? rx_face_slot(keys[k], 0u) : rx_face_find(keys[k]);
    }
    [[unroll]] for (int k = 0; k < RING; ++k) {
        uint slot = ring_slot[k] == RX_NO_FACE ? own : ring_slot[k];
        seen[k] = asked[slot];
        made[k] = generation[slot];
        ring_light[k] = light[slot];
        ring_square[k] = squares[slot];
    }
    // A cell has covered faces beside the visible ones. So a cell seen in another frame does not show that its face beside this one is bare.
    uint recent = part < CELL_PARTS ? RECENT : 0u;
    [[unroll]] for (int k = 0; k < RING; ++k) {
        if (frame.index + 1u - seen[k] > recent || made[k] != state.generation || ring_light[k].w == 0.0) ring_slot[k] = RX_NO_FACE;
    }
}

// Adds the faces of the ring, each by the number of its samples and by how likely chance alone makes the difference.
void add(vec4 own, float variance, inout vec3 sum, inout float samples) {
    [[unroll]] for (int k = 0; k < RING; ++k) {
        if (ring_slot[k] == RX_NO_FACE) continue;
        vec4 other = ring_light[k];
        float away = luminance(other.rgb) - luminance(own.rgb);
        float share = other.w * exp(-away * away / max(APART * APART * variance * (1.0 / own.w + 1.0 / other.w), 1e-30));
        sum += share * other.rgb;
        samples += share;
    }
}

void main() {
    uint i = rx_thread();
    if (i >= queue.count) return;
    uint entry = queue.faces[i], slot = entry_slot(entry);
    if (entry_number(entry) != 0u) return;
    RxFaceKey key;
    if (!rx_face_in_slot(slot, key)) return;
    vec4 own = light[slot];
    vec3 result = own.rgb;
    float mean = luminance(own.rgb), square = squares[slot];
    ivec3 cell;
    uint face, part;
    cell_of_key(key, cell, face, part);
    bool shares = own.w < FEW || cell_pixels(cell, face, part, float(push.pixels.y)) >= queue_narrow();
    // Few samples know little of their variance.
    if (shares && (own.w < (queue.noise < QUIET ? 16.0 : 64.0) || noisy(square - mean * mean, own.w, mean))) {
        look(slot, cell, face, part, 1, 0xffu);
        // The variance is that of all of them together.
        float samples = own.w;
        mean *= own.w;
        square *= own.w;
        [[unroll]] for (int k = 0; k < RING; ++k) {
            if (ring_slot[k] == RX_NO_FACE) continue;
            mean += ring_light[k].w * luminance(ring_light[k].rgb);
            square += ring_light[k].w * ring_square[k];
            samples += ring_light[k].w;
        }
        mean /= samples;
        float variance = max(square / samples - mean * mean, 0.0);

        // Around a corner only by one of the faces beside it: between two that touch there may be a wall. 0 1 2, 3 and 4, 5 6 7 are the rows.
        bool left = ring_slot[3] != RX_NO_FACE, right = ring_slot[4] != RX_NO_FACE;
        bool above = ring_slot[1] != RX_NO_FACE, below = ring_slot[6] != RX_NO_FACE;
        if (!left && !above) ring_slot[0] = RX_NO_FACE;
        if (!right && !above) ring_slot[2] = RX_NO_FACE;
        if (!left && !below) ring_slot[5] = RX_NO_FACE;
        if (!right && !below) ring_slot[7] = RX_NO_FACE;
        vec3 sum = own.w * own.rgb;
        samples = own.w;
        add(own, variance, sum, samples);
        // Straight on, each by the one before it, where there is still noise: one more, or three on a narrow strip.
        if (noisy(variance, samples, mean)) {
            int beside = 0;
            [[unroll]] for (int k = 0; k < RING; ++k) beside += ring_slot[k] != RX_NO_FACE ? 1 : 0;
            uint wanted = (above ? 1u : 0u) | (left ? 2u : 0u) | (right ? 4u : 0u) | (below ? 8u : 0u);
            for (int far = 2; far <= (beside > 5 ? 2 : 4) && wanted != 0u; ++far) {
                look(slot, cell, face, part, far, wanted);
                add(own, variance, sum, samples);
                [[unroll]] for (int k = 0; k < 4; ++k) wanted &= ring_slot[k] != RX_NO_FACE ? 15u : ~(1u << k);
            }
        }
        if (samples > 0.0) result = sum / samples;
    }
    soft[slot] = soft_pack(result);
}
