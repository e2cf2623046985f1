// Table of the share of light that single reflections of a white GGX surface keep: x is the cosine of the view, y the roughness. Made once.
#version 460
#include <raxel/light/bsdf.glsl>
#include <raxel/light/sobol.glsl>

layout(local_size_x = 8, local_size_y = 8) in;
layout(r32f) uniform writeonly image2D outKept;

void main() {
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy), size = imageSize(outKept);
    if (any(greaterThanEqual(texel, size))) return;
    vec2 at = vec2(texel) / vec2(size - 1);
    float cosine = max(at.x, 1e-3), alpha = rx_ggx_alpha(at.y), sum = 0.0;
    vec3 v = vec3(sqrt(1.0 - cosine * cosine), 0.0, cosine);
    for (uint i = 0u; i < 512u; ++i) {
        vec3 h = rx_ggx_visible_normal(v, alpha, rx_sobol(i, 0u, 1u));
        sum += rx_ggx_kept(reflect(-v, h), v, alpha);
    }
    imageStore(outKept, texel, vec4(sum / 512.0));
}
