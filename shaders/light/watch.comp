// Notices that the light or the world is another than in the last frame. The less has changed, the more samples of older light still count;
// much begins a new generation.
#version 460
#include "scene.glsl"
#define STATE_WRITES
#include "change.glsl"

layout(local_size_x = 1) in;
layout(push_constant) uniform Push { uint world_serial; uint world_edited; } push;

float ratio(float a, float b) {
    return abs(a - b) / max(max(abs(a), abs(b)), 1e-6);
}

void main() {
    vec4 sun = vec4(frame_true_sun(), frame.sun_strength);
    // One degree of the sun counts as much as a tenth of its strength.
    float change = max(ratio(state.sun.w, sun.w), 5.7 * distance(sun.xyz, state.sun.xyz));
    change = max(change, max(ratio(state.sky_strength, frame.sky_strength), ratio(state.lamp_strength, frame.lamp_strength)));
#ifdef SKY_TABLE
    // The moon and the clouds, unless it is the sun that has moved, which is counted already.
    vec4 light = vec4(sun_light.rgb, sky_clouds.x);
    if (change == 0.0) change = max(distance(light.rgb, state.light.rgb) / max(length(light.rgb) + length(state.light.rgb), 1e-6), distance(sky_way.xyz, state.way.xyz));
    change = max(change, abs(light.w - state.light.w) + ratio(sky_clouds.y, state.way.w));
    state.light = light;
    state.way = vec4(sky_way.xyz, sky_clouds.y);
#endif
    bool other = state.serial != push.world_serial;
    // If land is loaded around the camera, the world changes in nearly every frame of a flight. The light of
    // the remaining land hardly changes.
    bool edited = state.edited != push.world_edited || state.generation == 0u;
    bool changed = change > 1e-5 || other || edited;
    state.changed = changed ? 1u : 0u;
    if (changed) {
        // A quarter of a frame: after ten frames it is 2.4 % of the mean. A place that an edit has hit is new in two frames.
        state.cap = edited ? 0.05 : clamp(0.15 / max(change, 1e-6), 0.25, other ? LOADED : 64.0);
        // A sun that moves on slowly does not end the known light.
        if (state.cap < SLIGHT) state.generation += 1u;
    }
    state.serial = push.world_serial;
    state.edited = push.world_edited;
    state.sun = sun;
    state.sky_strength = frame.sky_strength;
    state.lamp_strength = frame.lamp_strength;
}
