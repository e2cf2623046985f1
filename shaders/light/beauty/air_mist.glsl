// The mean of the mist's density between two heights, 1 at its floor and below. It thins out over `height` voxels.
float mist_between(float a, float b, float height, float ground) {
    float low = min(a, b) - ground, high = max(a, b) - ground;
    if (high - low < 0.01 * height) return exp(-max(0.5 * (low + high), 0.0) / height);
    float below = min(high, 0.0) - min(low, 0.0);
    float above = height * (exp(-max(low, 0.0) / height) - exp(-max(high, 0.0) / height));
    return (below + above) / (high - low);
}
