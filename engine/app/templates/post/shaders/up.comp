// Adds a mip, enlarged with bilinear weights, to the finer one.
#version 460
layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba16f) uniform readonly image2D coarse;
layout(rgba16f) uniform image2D fine;
layout(push_constant) uniform Push {
    float spread;
};

vec4 coarse_at(ivec2 texel) {
    return imageLoad(coarse, clamp(texel, ivec2(0), imageSize(coarse) - 1));
}

void main() {
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(texel, imageSize(fine)))) return;

    vec2 place = (vec2(texel) + 0.5) * 0.5 - 0.5;
    ivec2 corner = ivec2(floor(place));
    vec2 weight = place - vec2(corner);
    vec4 upper = mix(coarse_at(corner), coarse_at(corner + ivec2(1, 0)), weight.x);
    vec4 lower = mix(coarse_at(corner + ivec2(0, 1)), coarse_at(corner + ivec2(1, 1)), weight.x);
    imageStore(fine, texel, imageLoad(fine, texel) + spread * mix(upper, lower, weight.y));
}
