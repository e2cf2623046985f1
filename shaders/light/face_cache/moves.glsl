// The effect of moving instances on light that faces keep. `moves_seen` of a slot has the number of the move after which the face took its last
// samples in its lowest 24 bits, and above it the share of lamps in its light. Needs cache.glsl.

layout(std430) readonly buffer Poses {
    uint moves;   // a number that changes after each frame in which an instance moved
    uint leaps;   // the number of the last frame in which a lamp went far
    uint last;    // the number of the last frame in which an instance moved, from 1
};

// Samples from before a move that still count. Far from the mover and from the shadow that it throws, light changes little.
const float SAMPLES_BEFORE_MOVE = 64.0;
// The same of a face that lamps light: they throw shadows of the mover to any distance. New samples soon outweigh so few.
const float LIT_BEFORE_MOVE = 8.0;
const float LIT_FROM = 0.02;   // share of lamps in the light of such a face
// The same of a lamp that is suddenly elsewhere, or moves fast: the place behind it must be dark soon.
const float SAMPLES_BEFORE_LEAP = 0.25;

const uint MOVES_MASK = 0xffffffu;

// The share of lamps in the light that a face keeps.
float moves_lamps(uint code) {
    return float(code >> 24) / 255.0;
}

// What a slot has seen after samples of this frame. The share of lamps is rounded up or down by a random number.
uint moves_code(float share, float random) {
    return moves & MOVES_MASK | uint(clamp(floor(255.0 * share + random), 0.0, 255.0)) << 24;
}

// How often an instance has moved since a face took its last samples.
uint moves_since(uint slot) {
    return moves - moves_seen[slot] & MOVES_MASK;
}

// The number of a slot's samples that still count.
float samples_after_moves(uint slot, float samples) {
    uint since = moves_since(slot);
    if (since == 0u) return samples;
    if (moves - leaps < since) return min(samples, SAMPLES_BEFORE_LEAP);
    return min(samples, moves_lamps(moves_seen[slot]) > LIT_FROM ? LIT_BEFORE_MOVE : SAMPLES_BEFORE_MOVE);
}
