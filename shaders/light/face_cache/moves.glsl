// The effect of moving instances on light that faces keep. Of each slot, `moves_seen` is the number of the move after which the face took
// its last samples. Needs cache.glsl.

layout(std430) readonly buffer Poses {
    uint moves;   // a number that changes after each frame in which an instance moved
    uint leaps;   // the number of the last frame in which a lamp went far
};

// Samples from before a move that still count: a move may change the light of any face, and new samples soon outweigh so few.
const float SAMPLES_BEFORE_MOVE = 8.0;
// The same of a lamp that is suddenly elsewhere, or moves fast: the place behind it must be dark soon.
const float SAMPLES_BEFORE_LEAP = 0.25;

// The number of a slot's samples that still count.
float samples_after_moves(uint slot, float samples) {
    if (moves_seen[slot] == moves) return samples;
    return min(samples, moves_seen[slot] < leaps ? SAMPLES_BEFORE_LEAP : SAMPLES_BEFORE_MOVE);
}
