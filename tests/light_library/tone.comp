#version 460
#include <raxel/random.glsl>
#include <raxel/tone.glsl>
layout(local_size_x = 1) in;
layout(std430) buffer Results { float results[]; };

void main() {
    float black = 0.0;
    for (uint curve = 0u; curve < 4u; ++curve) {
        float least = 1.0, before = rx_tone(vec3(0.0), curve).y;
        black = max(black, before);
        for (int i = 1; i <= 2000; ++i) {
            float now = rx_tone(vec3(exp2(-12.0 + float(i) * 0.01)), curve).y;
            least = min(least, now - before);
            before = now;
        }
        results[curve] = least;
    }
    results[4] = black;
    float off = 0.0;
    uint seed = 1u;
    for (int i = 0; i < 2000; ++i) {
        vec3 light = exp2(-8.0 + 9.0 * vec3(rx_random(seed), rx_random(seed), rx_random(seed)));
        vec3 back = rx_tone_neutral_inverse(rx_tone_neutral(light));
        off = max(off, length(back - light) / length(light));
    }
    results[5] = off;
}
