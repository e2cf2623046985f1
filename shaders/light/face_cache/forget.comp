// Empties the list of faces, decides how many visible faces are listed, and measures the noise of a sample and the size of cells. In a 256th of
// the table in each frame, frees the slots of faces that no pass has asked for in a long time. When the table fills up, looks through all of
// it, and faces that have left the picture go sooner.
#version 460
#include "../scene.glsl"

layout(local_size_x = 64) in;
#define QUEUE_ACCESS
#include "queue.glsl"
#define CACHE_ACCESS
#include "cache.glsl"
#include "goes_on.glsl"
#include "../change.glsl"
layout(push_constant) uniform Push { ivec2 size; float paths; float grain; float quarters; } push;

const float ENTRIES_MORE = 4.0;                      // entries for each pixel of a face's width, at most, where there is a path for each pixel
const float MOVING_MORE = 2.0;                       // times as many paths while sun, sky or lamps change, because old samples count less
const uint EACH = 16u;                               // slots that a thread looks through
const uint AGE[4] = uint[4](600u, 16u, 4u, 1u);      // frames, by pressure

shared uint finest;   // the finest grain that fits the view
shared uint roomy;    // the finest grain that leaves a fifth of the room free

uint pixels() {
    return uint(push.size.x * push.size.y);
}

// The width of a cell, or of a part of a face, on the picture.
float kept_width(float width, float grain) {
    if (width >= max(push.quarters * max(16.0 * queue.noise, 1.0), 2.0 * grain)) return 0.5 * width;
    float wider = width;
    for (uint i = 0u; i < 4u && wider < grain; ++i) wider *= 2.0;
    return wider < grain ? 64.0 * width : wider;
}

// Chooses a grain that fits the view: the last frame's, unless it is too fine or much too coarse. A cell or part takes as many slots as its share of a
// pixel, and a pixel takes one at most. Each thread tries a grain of its own.
void choose_grain() {
    const float STEP = 0.1;   // octaves
    uint own = gl_LocalInvocationIndex;
    bool all_fit = pixels() <= FIT_ROOM || push.grain < 0.0;
    float grain = own == 0u ? max(push.grain, 0.0) : min(max(push.grain, 0.25) * exp2(STEP * float(own)), max(push.grain, 16.0));
    float expected = 0.0;
    if (own == 0u) {
        finest = gl_WorkGroupSize.x - 1u;
        roomy = finest;
    }
    barrier();
    if (!all_fit) {
        uint from = fit_goes_on(pixels()) ? 0u : FIT_BINS;
        for (uint bin = 0u; bin < FIT_BINS; ++bin) {
            float width = kept_width(fit_width(bin), grain);
            expected += float(FIT_APART * fit.bins[from + bin]) / max(width * width, 1.0);
        }
    }
    float crowding = fit.crowding > 0.0 ? fit.crowding : 2.0;
    if (expected * crowding <= float(FIT_ROOM)) atomicMin(finest, own);
    if (expected * crowding <= 0.8 * float(FIT_ROOM)) atomicMin(roomy, own);
    uint chosen = fit.chosen;
    barrier();
    chosen = clamp(chosen, finest, roomy);
    if (own == chosen) {
        fit.chosen = chosen;
        fit.grain = push.grain < 0.0 ? -1.0 : grain;
        fit.expected = expected;
        fit.crowding = crowding;
    }
    for (uint bin = own; bin < 2u * FIT_BINS; bin += gl_WorkGroupSize.x) fit.bins[bin] = 0u;
}

void begin() {
    // As many faces are in sight as in the last frame, about. One in `every` is listed; while that leaves paths over, each gets more.
    float paths = min(push.paths * (state.changed != 0u && state.cap < LOADED ? MOVING_MORE : 1.0), 2.0);
    float budget = max(paths * float(pixels()), 1.0), most = max(ENTRIES_MORE * paths, 1.0), wanted = max(float(queue.wanted), 1.0);
    queue.every = uint(clamp(ceil(wanted / budget), 1.0, 16.0));
    if (queue.count > 0u) queue.per_width *= 0.9 * budget / float(queue.count);
    queue.per_width = queue.per_width > 0.0 ? clamp(queue.per_width, 1.0, most) : min(most, 2.0);
    queue.per_new_width = min(queue.per_width, queue.wanted > 0u ? max(0.9 * float(queue_room(push.size)) / wanted, 1.0) : 2.0);
    queue.wanted = 0u;
    queue.count = 0u;
    queue.lost = 0u;
    // One number for all faces: a number of samples that follows each face's own samples would stop where they happen to lie low.
    // At first, a few wide faces have enough of them, which says little about all others.
    if (queue.spreads >= 16u && (queue.noise > 0.0 || queue.spreads >= queue.seen / 4u)) {
        float noise = float(queue.spread) / (QUEUE_ONE * float(queue.spreads));
        queue.noise += (noise - queue.noise) * (queue.noise > 0.0 ? 0.1 : 1.0);
    }
    if (queue.showing > 0u) queue.bright = exp2(float(queue.logs) / (QUEUE_ONE * float(queue.showing)) + QUEUE_LOG_LEAST);
    queue.seen = 0u;
    queue.spread = 0u;
    queue.spreads = 0u;
    queue.logs = 0u;
    queue.showing = 0u;
    fit.cell = frame.camera_cell;
    fit.pixels = pixels();
    fit.frac = frame.camera_frac;
    fit.tangent = frame.tan_half_fov.y;
    fit.forward = frame.view_to_world[2].xyz;
}

// A slot behind which the next one is empty ends every search that comes to it, so it may be empty, too: searches stay short.
void forget(uint first) {
    uint gone = 0u, next = face_keys[first + EACH & RX_FACE_SLOTS - 1u];
    for (uint i = EACH; i-- > 0u;) {
        uint slot = first + i, word = face_keys[slot];
        if (rx_face_taken(word) && frame.index + 1u - asked[slot] > AGE[fit.pressure]) {
            word = RX_FACE_FREED;
            face_keys[slot] = word;
            light[slot] = vec4(0.0);
            asked[slot] = 0u;
            ++gone;
        }
        if (word == RX_FACE_FREED && next == 0u) {
            word = 0u;
            face_keys[slot] = word;
        }
        next = word;
    }
    if (gone > 0u) atomicAdd(fit.used, 0u - gone);
}

void main() {
    if (gl_WorkGroupID.x == 0u) {
        choose_grain();
        barrier();
        if (gl_LocalInvocationIndex == 0u) begin();
    }
    if (fit.pressure == 0u && gl_WorkGroupID.x >> 2 != (frame.index & 255u)) return;
    uint first = gl_GlobalInvocationID.x * EACH;
    if (first < RX_FACE_SLOTS) forget(first);
}
