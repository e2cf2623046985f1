// A gradient that turns slowly. Stores every texel.
#version 460
layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba16f) uniform writeonly image2D outColor;
layout(push_constant) uniform Push { float time; };   // seconds

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    ivec2 size = imageSize(outColor);
    if (any(greaterThanEqual(pixel, size))) return;
    vec2 at = (vec2(pixel) + 0.5) / vec2(size) - 0.5;
    float along = 0.5 + dot(at, vec2(cos(0.3 * time), sin(0.3 * time)));
    imageStore(outColor, pixel, vec4(mix(vec3(0.05, 0.06, 0.14), vec3(0.85, 0.5, 0.35), along), 1.0));
}
