// Exposure: the mean of the logarithms between the darker half and the brightest twentieth becomes a middle grey, partly, so that night stays
// darker than day; the eye follows in about a second.
#version 460
layout(local_size_x = 1) in;
layout(std430) readonly buffer Histogram { uint bins[256]; };
layout(std430) buffer Eye { float exposure; float started; };
layout(push_constant) uniform Push { float delta; } push;

const float FROM = 0.40, UNTIL = 0.95;

void main() {
    float all = 0.0;
    for (int i = 0; i < 256; ++i) all += float(bins[i]);
    float below = 0.0, sum = 0.0, weight = 0.0;
    for (int i = 0; i < 256; ++i) {
        float n = float(bins[i]), from = max(below, FROM * all), to = min(below + n, UNTIL * all);
        if (to > from) {
            sum += (to - from) * ((float(i) + 0.5) / 256.0 * 24.0 - 12.0);
            weight += to - from;
        }
        below += n;
    }
    float level = sum / max(weight, 1.0);
    float goal = clamp(exp2(-0.75 * level - 1.35), 0.02, 50.0);
    exposure = started == 0.0 ? goal : exp2(mix(log2(exposure), log2(goal), 1.0 - exp(-1.5 * push.delta)));
    started = 1.0;
}
