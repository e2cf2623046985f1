// 5 x 5 with holes, over the same plane only.
#version 460
#include "common.glsl"
layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba32i) uniform readonly iimage2D hits;
layout(rgba16f) uniform readonly image2D light;
layout(rgba16f) uniform writeonly image2D outLight;
layout(push_constant) uniform Push { uint round; } push;
void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), size = imageSize(outLight);
    if (any(greaterThanEqual(pixel, size))) return;
    ivec4 hit = imageLoad(hits, pixel);
    vec4 middle = imageLoad(light, pixel);
    uint axis = rx_face_axis(hit_face(hit.w));
    if (hit.w < 0 || axis > 2u) { imageStore(outLight, pixel, middle); return; }
    vec3 l = log(middle.rgb + 0.02);
    float sharp = 0.12 * middle.w;    // the longer it was averaged, the less is taken from others
    vec4 sum = vec4(0.0);
    for (int y = -2; y <= 2; ++y) for (int x = -2; x <= 2; ++x) {
        ivec2 q = pixel + (1 << push.round) * ivec2(x, y);
        if (any(lessThan(q, ivec2(0))) || any(greaterThanEqual(q, size))) continue;
        ivec4 h = imageLoad(hits, q);
        if (h.w < 0 || hit_face(h.w) != hit_face(hit.w) || h[axis] != hit[axis]) continue;
        vec4 c = imageLoad(light, q);
        vec3 d = log(c.rgb + 0.02) - l;
        float w = exp(-0.4 * float(x * x + y * y) - sharp * dot(d, d));
        sum += w * vec4(c.rgb, 1.0);
    }
    imageStore(outLight, pixel, vec4(sum.rgb / sum.w, middle.w));
}
