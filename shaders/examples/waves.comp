// One tick of the wave equation on a height field, by finite differences: h(t+1) = 2 h(t) − h(t−1) + c² ∇²h(t), damped. Edges reflect.
#version 460
layout(local_size_x = 8, local_size_y = 8) in;
layout(r32f) uniform readonly image2D before;
layout(r32f) uniform readonly image2D earlier;
layout(r32f) uniform writeonly image2D outHeight;
layout(push_constant) uniform Push {
    uint tick;
    uint drops;
};

const float SPEED_SQUARED = 0.24;   // (cells a tick)²; stable up to 0.5
const float DAMPING = 0.996;        // of the velocity, each tick
const float RADIUS = 4.0;           // of a drop, in cells

float at(ivec2 cell) {
    return imageLoad(before, clamp(cell, ivec2(0), imageSize(before) - 1)).x;
}

// The place where drop n falls. Steps of the golden ratio and of its square leave no gaps and no pattern.
vec2 drop(uint n) {
    return fract(vec2(0.5, 0.5) + float(n) * vec2(0.75487766, 0.56984029)) * vec2(imageSize(before));
}

void main() {
    ivec2 cell = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(cell, imageSize(outHeight)))) return;
    float here = at(cell);
    float laplacian = at(cell + ivec2(1, 0)) + at(cell - ivec2(1, 0)) + at(cell + ivec2(0, 1)) + at(cell - ivec2(0, 1)) - 4.0 * here;
    float height = here + DAMPING * (here - imageLoad(earlier, cell).x) + SPEED_SQUARED * laplacian;
    if (tick % drops == 0u) {
        vec2 away = (vec2(cell) + 0.5 - drop(tick / drops)) / RADIUS;
        height -= 0.6 * exp(-dot(away, away));
    }
    imageStore(outHeight, cell, vec4(height));
}
