// The new samples of each listed face go into its mean, and their squares into another one. Their distance from the face's earlier light
// measures their noise.
#version 460
#include <raxel/thread.glsl>

layout(local_size_x = 64) in;
#define QUEUE_ACCESS
#include "queue.glsl"
layout(std430) readonly buffer Fresh { vec4 fresh[]; };
#include "../change.glsl"
#define CACHE_ACCESS
#include "cache.glsl"
layout(push_constant) uniform Push { int history; } push;
#include "../renew.glsl"
#ifdef RX_BINDS_Poses
#include <raxel/random.glsl>
#include "moves.glsl"
#endif

const float JUDGES_FROM = 8.0;   // samples of a mean that others are held against
const float LATE_TIMES = 3.0;    // old samples of a late face count at most as many times the new ones
const float JUDGED_MOST = 8.0;   // samples of a frame that are compared with the kept mean, so that wide faces count like others
const float SPREAD_MOST = 64.0;  // so that the sum over all faces fits

shared uint spread;
shared uint spreads;

float luminance(vec3 light) {
    return min(dot(light, vec3(0.2126, 0.7152, 0.0722)), 1e15);
}

// Takes the new samples in, and notes how noisy they are.
void resolve(uint i) {
    uint entry = queue.faces[i], slot = entry_slot(entry), samples = entries_of_face(entry);
    if (entry_number(entry) != 0u) return;
    vec3 sum = vec3(0.0);
    float square = 0.0, lamps = 0.0, added = float(samples), judged = min(added, JUDGED_MOST), first = 0.0;
    for (uint k = 0u; k < samples; ++k) {
        vec3 one = fresh[i + k].rgb;
        sum += one;
        lamps += fresh[i + k].w;
        if (k < uint(JUDGED_MOST)) first += luminance(one) / judged;
        square += luminance(one) * luminance(one);
    }
    vec4 old = light[slot];
    if (entry_is_late(entry)) old.w = min(old.w, max(LATE_SAMPLES, LATE_TIMES * added));
#ifdef RX_BINDS_Poses
    old.w = samples_after_moves(slot, old.w);
#endif
    if (old.w >= JUDGES_FROM && generation[slot] == state.generation && queue.bright > 0.0) {
        // Samples of one frame are spread evenly, so compare their mean with the kept mean. The variance of a mean of n samples is an n-th of a
        // sample's. Noise shows less where sunlight comes on top, or all else is much brighter.
        float mean = luminance(old.rgb), off = first - mean;
        float relative = off * off / ((1.0 / judged + 1.0 / old.w) * (mean * mean + queue.bright * queue.bright));
        atomicAdd(spread, uint(QUEUE_ONE * min(relative, SPREAD_MOST)));
        atomicAdd(spreads, 1u);
    }
    vec4 now = renewed(slot, old, sum, added, float(push.history));
    light[slot] = now;
#ifdef RX_BINDS_Poses
    float lit = moves_lamps(moves_seen[slot]) * luminance(old.rgb);
    lit += (lamps - added * lit) / now.w;
    moves_seen[slot] = moves_code(lit / max(luminance(now.rgb), 1e-20), float(rx_hash(floatBitsToUint(sum.x)) >> 8) / 16777216.0);
#endif
    squares[slot] = (square + (now.w - added) * squares[slot]) / now.w;
}

void main() {
    bool first = gl_LocalInvocationIndex == 0u;
    if (first) {
        spread = 0u;
        spreads = 0u;
    }
    barrier();
    uint i = rx_thread();
    if (i < queue.count) resolve(i);
    barrier();
    if (first && spreads > 0u) {
        atomicAdd(queue.spread, spread);
        atomicAdd(queue.spreads, spreads);
    }
}
