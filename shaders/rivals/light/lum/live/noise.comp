// A cube of smooth noise, 0 to 1, that repeats on every axis. Made once.
#version 460
#include <raxel/random.glsl>

layout(local_size_x = 4, local_size_y = 4, local_size_z = 4) in;
layout(r16f) uniform writeonly image3D outNoise;

float value(ivec3 cell, int period) {
    return float(rx_hash(cell % period + 17 * period) >> 8) * 5.9604644775390625e-8;
}

float noise(vec3 at, int period) {
    ivec3 cell = ivec3(floor(at));
    vec3 part = at - vec3(cell);
    part = part * part * (3.0 - 2.0 * part);
    float sum = 0.0;
    for (int i = 0; i < 8; ++i) {
        ivec3 step = ivec3(i & 1, i >> 1 & 1, i >> 2);
        vec3 along = mix(1.0 - part, part, vec3(step));
        sum += along.x * along.y * along.z * value(cell + step, period);
    }
    return sum;
}

void main() {
    ivec3 texel = ivec3(gl_GlobalInvocationID), size = imageSize(outNoise);
    if (any(greaterThanEqual(texel, size))) return;
    vec3 at = (vec3(texel) + 0.5) / vec3(size);
    imageStore(outNoise, texel, vec4((noise(4.0 * at, 4) + 0.5 * noise(8.0 * at, 8)) / 1.5));
}
