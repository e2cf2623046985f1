#version 460
// A sound: bars for its spectrum, octave by octave, and a line for its waveform.
layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba16f) uniform writeonly image2D outColor;
uniform sampler2D sound;

const float BARS = 64.0;
const float LOWEST = 40.0;     // Hz
const float OCTAVES = 7.0;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    ivec2 size = imageSize(outColor);
    if (any(greaterThanEqual(pixel, size))) return;
    vec2 at = vec2(pixel.x + 0.5, size.y - pixel.y - 0.5) / vec2(size);   // y up
    vec3 color = vec3(0.02, 0.03, 0.06);

    float bar = at.x * BARS;
    float hz = LOWEST * exp2(OCTAVES * (floor(bar) + 0.5) / BARS);
    float level = textureLod(sound, vec2((hz / 23.4375 + 0.5) / 512.0, 0.25), 0.0).x;
    if (fract(bar) < 0.8 && at.y < 0.7 * level) {
        color = mix(vec3(0.05, 0.45, 0.75), vec3(1.0, 0.55, 0.15), at.y / 0.7);
    }

    float wave = textureLod(sound, vec2(at.x, 0.75), 0.0).x;
    float away = abs(at.y - 0.5 - 0.7 * (wave - 0.5)) * float(size.y);
    color = mix(color, vec3(0.9, 0.95, 1.0), clamp(1.5 - away, 0.0, 1.0));
    imageStore(outColor, pixel, vec4(color, 1.0));
}
