// Noise of slices of the air is shared with the columns around them, up to a voxel away. Means of few frames take up to five by five columns
// together, means of many frames fewer, so that a view at rest shows each slice for itself. Walls keep their air apart.
#version 460
#include "../scene.glsl"
#include "air_slices.glsl"
layout(local_size_x = 8, local_size_y = 8) in;
uniform sampler3D sunBySlice;    // alpha is the number of frames in the mean, negative where a wall hid the slice
uniform sampler3D skyBySlice;
uniform sampler3D lampsBySlice;
layout(rgba32f) uniform writeonly image3D outSun;
layout(rgba32f) uniform writeonly image3D outSky;
layout(rgba32f) uniform writeonly image3D outLamps;

const float WIDEST = 1.5; // variance of the bell at most, in columns
const float FEW = 8.0;    // frames of a mean that still shares all its noise

// The mean around a slice: columns count by a bell of a width that shrinks with the number of frames.
vec4 around(sampler3D texels, ivec3 slice, ivec3 size) {
    vec4 own = texelFetch(texels, slice, 0);
    float wide = slice_depth((float(slice.z) + 0.5) / float(size.z)) * 2.0 * frame.tan_half_fov.x / float(size.x);   // of a column, in voxels
    float spread = min(1.0 / (wide * wide), WIDEST) * min(FEW / max(abs(own.a), 1.0), 1.0);   // variance of the bell, in columns
    if (spread < 0.02) return own;
    vec3 sum = vec3(0.0);
    float weights = 0.0;
    for (int i = 0; i < 25; ++i) {
        ivec2 step = ivec2(i % 5, i / 5) - 2, column = slice.xy + step;
        if (any(lessThan(column, ivec2(0))) || any(greaterThanEqual(column, size.xy))) continue;
        vec4 tap = texelFetch(texels, ivec3(column, slice.z), 0);
        if ((tap.a < 0.0) != (own.a < 0.0)) continue;
        float weight = exp(-0.5 * float(step.x * step.x + step.y * step.y) / spread);
        sum += weight * tap.rgb;
        weights += weight;
    }
    return vec4(sum / weights, own.a);
}

void main() {
    ivec3 slice = ivec3(gl_GlobalInvocationID), size = imageSize(outSun);
    if (any(greaterThanEqual(slice, size))) return;
    imageStore(outSun, slice, around(sunBySlice, slice, size));
    imageStore(outSky, slice, around(skyBySlice, slice, size));
    imageStore(outLamps, slice, around(lampsBySlice, slice, size));
}
