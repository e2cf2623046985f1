// Traces one path from each pixel's first hit. With HASH_CACHE, the path ends at a cell that knows the rest. With
// LAMPS_APART, another pass draws lamps.
#version 460
#include <raxel/world.glsl>
#include "light/scene.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba32i) uniform readonly iimage2D hits;
layout(rgba32f) uniform readonly image2D places;
layout(rgba32f) uniform writeonly image2D outPath;
#ifdef HASH_CACHE
#include "light/face_cache/cache.glsl"
#include "light/change.glsl"
layout(push_constant) uniform Push { int candidates; int ready; float cell; } push;
#include "../hash_cache/kept.glsl"
#else
#ifdef LAMPS_APART
#define PATH_LAMPS_APART
#endif
layout(push_constant) uniform Push { int candidates; } push;
#endif
#define PATH_CANDIDATES push.candidates
#include "light/path.glsl"

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, imageSize(outPath)))) return;
    ivec4 hit = imageLoad(hits, pixel);
    vec3 found = vec3(0.0);
    if (hit.w >= 0 && hit_face(hit.w) != RX_FACE_INSIDE) {
        RxSampler numbers = rx_sampler(frame.index, scene_seed(uint(pixel.x) + rx_hash(uint(pixel.y) + 99u)));
        found = path_light(hit.xyz, hit_face(hit.w), imageLoad(places, pixel).xy, numbers);
    }
    imageStore(outPath, pixel, vec4(found, 1.0));
}
