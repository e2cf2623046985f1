#version 460
// A pattern in two colours: each param of graphs/examples/params.toml arrives as a push constant.
layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba16f) uniform writeonly image2D outColor;
layout(push_constant) uniform Push {
    vec3 front;     // linear
    float width;    // pixels
    vec3 back;
    float turn;     // degrees
    uint pattern;   // 0 discs, 1 stripes, 2 squares
    bool swapped;
};

// 1 inside, 0 outside, a pixel of both between them. `at` is in periods from the centre of the period, -0.5 to 0.5.
float inside(vec2 at) {
    float distance = pattern == 0 ? length(at) - 0.35
                   : pattern == 1 ? abs(at.x) - 0.25
                                  : max(abs(at.x), abs(at.y)) - 0.3;
    return clamp(0.5 - distance * width, 0.0, 1.0);
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    ivec2 size = imageSize(outColor);
    if (any(greaterThanEqual(pixel, size))) return;
    float angle = radians(turn);
    mat2 rotation = mat2(cos(angle), sin(angle), -sin(angle), cos(angle));
    float share = inside(fract(rotation * (vec2(pixel) - 0.5 * vec2(size)) / width) - 0.5);
    imageStore(outColor, pixel, vec4(mix(back, front, swapped ? 1.0 - share : share), 1.0));
}
