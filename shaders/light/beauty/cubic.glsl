// Weights of four texels in a row for a place between the inner two (Catmull and Rom, 1974). They keep a mean over many frames sharp:
// linear weights would blur it a little in each frame.
vec4 cubic(float t) {
    return 0.5 * vec4(((2.0 - t) * t - 1.0) * t, (3.0 * t - 5.0) * t * t + 2.0, ((4.0 - 3.0 * t) * t + 1.0) * t, (t - 1.0) * t * t);
}
