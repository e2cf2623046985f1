// Weights of four texels in a row for a place between the inner two (Catmull and Rom, 1974): a mean over many frames stays sharp, which
// linear weights blur a little in each.
vec4 cubic(float t) {
    return 0.5 * vec4(((2.0 - t) * t - 1.0) * t, (3.0 * t - 5.0) * t * t + 2.0, ((4.0 - 3.0 * t) * t + 1.0) * t, (t - 1.0) * t * t);
}
