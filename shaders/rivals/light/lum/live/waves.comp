// A tick of the water: four maps of heights, each a sum of sines. Frequencies, heights and directions go on from one sine to the next (Lum's
// updateWater). Every map repeats after its side, but four maps of different sizes together repeat nowhere in sight.
#version 460

layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba16f) uniform writeonly image2D outWaves;
layout(push_constant) uniform Push { uint tick; float delta; } push;

// Whole waves along both sides, so that the map has no seam.
float height(vec2 at, float time) {
    float sum = 0.0, all = 0.0, strength = 1.0;
    for (int i = 0; i < 12; ++i) {
        float turn = 0.8 + 0.7 * sin(2.4 * float(i)), size = 1.0 + 0.55 * float(i);
        vec2 waves = round(size * vec2(cos(turn), sin(turn)));
        float number = max(length(waves), 1.0);
        sum += strength * sin(6.2831853 * dot(waves, at) - 2.2 * sqrt(number) * time + 1.7 * float(i));
        all += strength;
        strength *= 0.84;
    }
    return sum / all;
}

void main() {
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy), size = imageSize(outWaves);
    if (any(greaterThanEqual(texel, size))) return;
    vec2 at = (vec2(texel) + 0.5) / vec2(size);
    float time = float(push.tick) * push.delta;
    imageStore(outWaves, texel, vec4(height(at, time / 1.25), height(at.yx, time / 1.5), height(at + 0.31, time / 2.0), height(at.yx + 0.67, time / 2.6)));
}
