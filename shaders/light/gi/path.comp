// One path from what each pixel sees.
#version 460
#include <raxel/world.glsl>
#include "../scene.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba32i) uniform readonly iimage2D hits;
layout(rgba32f) uniform readonly image2D places;
layout(rgba32f) uniform writeonly image2D outPath;
layout(push_constant) uniform Push { int candidates; } push;
#define PATH_CANDIDATES push.candidates
#include "../path.glsl"

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, imageSize(outPath)))) return;
    ivec4 hit = imageLoad(hits, pixel);
    vec3 light = vec3(0.0);
    if (hit.w >= 0 && hit_face(hit.w) != RX_FACE_INSIDE) {
        RxSampler numbers = rx_sampler(frame.index, scene_seed(uint(pixel.x) + rx_hash(uint(pixel.y) + 99u)));
        light = path_light(hit.xyz, hit_face(hit.w), imageLoad(places, pixel).xy, numbers);
    }
    imageStore(outPath, pixel, vec4(light, 1.0));
}
