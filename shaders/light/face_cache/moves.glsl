// What moving instances do to light that faces keep. MOVES_ACCESS is empty where the shader writes it.
#ifndef MOVES_ACCESS
#define MOVES_ACCESS readonly
#endif

layout(std430) readonly buffer Poses { uint moves; };         // another number after each frame in which an instance has moved
layout(std430) MOVES_ACCESS buffer MovesSeen { uint moves_seen[]; };  // that number when the face of a slot took its last samples

// Samples from before a move that still count: a move may change the light of any face, and new samples soon outweigh so few.
const float SAMPLES_BEFORE_MOVE = 8.0;

// How many of the samples of a slot still count.
float samples_after_moves(uint slot, float samples) {
    return moves_seen[slot] == moves ? samples : min(samples, SAMPLES_BEFORE_MOVE);
}
