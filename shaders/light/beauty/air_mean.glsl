// Means over frames of the light in slices of the view: they follow the camera, and take nothing over from air that a wall hid. Needs
// scene.glsl.
#include "cubic.glsl"

const float LEAST_SEEN = 0.1;     // of the weight of texels around a place
const float FADES_AT_REST = 0.1;  // frames of a mean, in each that does not see the slice

// The mean of earlier frames at a place.
struct Mean {
    vec3 light;
    float frames;
    bool seen;      // false: only walls were near, and the light is that right before them
};

// The mean at a place, 0 to 1 on each axis. The texture's alpha is the number of frames, negative if a wall hid the slice in all of them. Cubic
// between texels, within the range of the nearest ones. If a wall hides some, linear between the others.
Mean mean_between(sampler3D texels, vec3 place) {
    ivec3 size = textureSize(texels, 0);
    vec3 at = place * vec3(size) - 0.5, part = at - floor(at);
    ivec3 base = ivec3(floor(at));
    vec4 along = cubic(part.x), down = cubic(part.y), deep = cubic(part.z);
    vec4 sum = vec4(0.0), low = vec4(1e30), high = vec4(-1e30), of_seen = vec4(0.0);
    float seen = 0.0;
    for (int i = 0; i < 64; ++i) {
        ivec3 step = ivec3(i & 3, i >> 2 & 3, i >> 4);
        vec4 tap = texelFetch(texels, clamp(base + step - 1, ivec3(0), size - 1), 0);
        bool hidden = tap.a < 0.0;
        tap.a = abs(tap.a);
        sum += along[step.x] * down[step.y] * deep[step.z] * tap;
        if (any(equal(step, ivec3(0))) || any(equal(step, ivec3(3)))) continue;
        low = min(low, tap);
        high = max(high, tap);
        if (hidden) continue;
        vec3 weights = mix(1.0 - part, part, equal(step, ivec3(2)));
        float weight = weights.x * weights.y * weights.z;
        of_seen += weight * tap.a * vec4(tap.rgb, 1.0);
        seen += weight;
    }
    bool some = seen > LEAST_SEEN && of_seen.a > 0.0;
    // A mean that only some of them have counts for less.
    if (some && seen < 0.999) return Mean(of_seen.rgb / of_seen.a, of_seen.a * seen, true);
    sum = clamp(sum, low, high);
    return Mean(sum.rgb, sum.a, some);
}

// The mean with the light of this frame, at most `most` frames of it, as it is kept. If a wall hides the slice (`!seen`),
// `light` is the light right before the wall. It counts only if nothing else is known. The known mean fades: slowly at rest,
// when ways through other pixels may see the slice.
vec4 mean_with(Mean before, vec3 light, bool seen, float most) {
    float frames = min(before.frames, most - 1.0);
    if (!seen && before.seen && frames > 1.0) return vec4(before.light, frames - (frame.still > 0u ? FADES_AT_REST : 1.0));
    if (seen != before.seen) frames = 0.0;
    return vec4(mix(before.light, light, 1.0 / (frames + 1.0)), seen ? frames + 1.0 : -frames - 1.0);
}
