// Weights of four texels in a row for a place between the middle two (Catmull and Rom, 1974): a mean that goes on over many frames stays sharp,
// which linear weights blur a little in each.
vec4 cubic(float t) {
    return 0.5 * vec4(((2.0 - t) * t - 1.0) * t, (3.0 * t - 5.0) * t * t + 2.0, ((4.0 - 3.0 * t) * t + 1.0) * t, (t - 1.0) * t * t);
}

// What a texture has at a place, 0 to 1 on each axis: cubic between texels, within what the nearest of them have. Texels with a negative alpha do not count
// where only those that are `seen` do; if none of the nearest counts, alpha is 0. The result has no sign in alpha.
vec4 cubic_between(sampler3D texels, vec3 place, bool seen) {
    const float LEAST = 0.05;   // of the weights of the nearest
    ivec3 size = textureSize(texels, 0);
    vec3 at = place * vec3(size) - 0.5, part = at - floor(at);
    ivec3 base = ivec3(floor(at));
    vec4 along = cubic(part.x), down = cubic(part.y), deep = cubic(part.z);
    vec4 sum = vec4(0.0), low = vec4(1e30), high = vec4(-1e30), near = vec4(0.0);
    float counted = 0.0;
    for (int i = 0; i < 64; ++i) {
        ivec3 step = ivec3(i & 3, i >> 2 & 3, i >> 4);
        vec4 tap = texelFetch(texels, clamp(base + step - 1, ivec3(0), size - 1), 0);
        bool counts = !seen || tap.a >= 0.0;
        tap.a = abs(tap.a);
        sum += along[step.x] * down[step.y] * deep[step.z] * tap;
        if (any(equal(step, ivec3(0))) || any(equal(step, ivec3(3)))) continue;
        low = min(low, tap);
        high = max(high, tap);
        if (!counts) continue;
        vec3 beside = mix(1.0 - part, part, equal(step, ivec3(2)));
        near += beside.x * beside.y * beside.z * tap;
        counted += beside.x * beside.y * beside.z;
    }
    if (counted > 0.999) return clamp(sum, low, high);
    return counted > LEAST ? near / counted : vec4(0.0);
}
