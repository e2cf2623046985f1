// One round of an edge-avoiding filter over 3 × 3 texels. Each round doubles their distance (Dammertz et al., "Edge-Avoiding À-Trous
// Wavelet Transform for fast Global Illumination Filtering", 2010).
#version 460
layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba8_snorm) uniform readonly image2D normals;
layout(r32f) uniform readonly image2D depths;
layout(rgba16f) uniform readonly image2D noisy;
layout(rgba16f) uniform writeonly image2D smoothed;
layout(push_constant) uniform Push {
    uint round;  // texels are 2^round apart
} push;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    ivec2 size = imageSize(smoothed);
    if (any(greaterThanEqual(pixel, size))) return;

    vec3 normal = imageLoad(normals, pixel).xyz;
    float depth = imageLoad(depths, pixel).x;
    vec4 sum = vec4(0.0);
    float weights = 0.0;
    for (int i = 0; i < 9; ++i) {
        ivec2 offset = ivec2(i % 3, i / 3) - 1;
        ivec2 at = clamp(pixel + (offset << push.round), ivec2(0), size - 1);
        float weight = (offset.x == 0 ? 0.5 : 0.25) * (offset.y == 0 ? 0.5 : 0.25);
        weight *= 0.02 + 0.98 * max(dot(normal, imageLoad(normals, at).xyz), 0.0);
        weight *= exp(-4.0 * abs(imageLoad(depths, at).x - depth) / max(depth, 1.0));
        sum += weight * imageLoad(noisy, at);
        weights += weight;
    }
    imageStore(smoothed, pixel, weights > 0.0 ? sum / weights : imageLoad(noisy, pixel));
}
