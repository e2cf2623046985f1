// A kept mean of light with new samples in it. Needs change.glsl, and `generation` as that of each slot.

// `sum` of `added` samples joins the mean `old`, whose w is the number of its samples, up to `history` of them.
vec4 renewed(uint slot, vec4 old, vec3 sum, float added, float history) {
    // After a slight change, the samples of `state.cap` frames still count; after a greater one, that many samples; those of older
    // generations, hardly.
    if (state.changed != 0u) old.w = min(old.w, state.cap < SLIGHT ? state.cap : state.cap * added);
    if (generation[slot] != state.generation) old.w = min(old.w, 0.5);
    generation[slot] = state.generation;
    float n = min(old.w, max(history - added, 0.0)) + added;
    return vec4(old.rgb + (sum - added * old.rgb) / n, n);
}
