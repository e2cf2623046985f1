// The changes of the light since the last frame, from watch.comp. The shader that writes it defines `STATE_WRITES`; to all others it is a
// uniform block, which leaves them a storage buffer more. It has the same places in both.
const float SLIGHT = 4.0;   // frames that still count after a change that begins no new generation, at least
const float LOADED = 16.0;  // frames that still count after land was loaded

#ifdef STATE_WRITES
layout(std430) buffer State {
#else
layout(std140) uniform State {
#endif
    uint generation;    // one more with each great change of the light or the world
    float cap;          // frames from before the change whose samples still count
    uint changed;       // 1 in the frame of a change
    uint serial;        // of the world that it is for
    vec4 sun;           // direction, strength
    float sky_strength;
    float lamp_strength;
    uint edited;
    uint unused;
    vec4 light;         // with SKY_TABLE: irradiance of the sun or the moon, share of the clouds
    vec4 way;           // the direction to it, base of the clouds
} state;
