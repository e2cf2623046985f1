// Second stage: four rays from each texel to the sun, as in the original, but to its disc.
#version 460
#include <raxel/world.glsl>
#include <raxel/thread.glsl>
#include "light/scene.glsl"
#include "light/face_cache/box.glsl"

layout(local_size_x = 64) in;
#include "light/face_cache/cache.glsl"
#include "light/unwrapped.glsl"
#include "work.glsl"
layout(std430) buffer SunTexels { vec2 sun_texels[]; };
layout(push_constant) uniform Push { int history; } push;
#include "item.glsl"

const uint RAYS = 4u;

void main() {
    uint i = rx_thread();
    if (i >= work.count) return;
    Item item;
    if (!item_at(i, item) || item.texel == NO_ITEM) return;
    vec3 sun = frame_sun(), normal = rx_normal(item.face);
    float sum = 0.0;
    for (uint k = 0u; k < RAYS; ++k) {
        uint index = RAYS * frame.index + k;
        vec2 uv = item.corner + item.side * rx_sobol(index, 0u, item.seed);
        vec3 to = rx_sun_point(sun, rx_sobol(index, 1u, item.seed));
        float cosine = dot(normal, to);
        RxHit block;
        if (cosine > 0.0 && frame.sun_strength > 0.0 && !rx_trace(rx_ray_from_face(item.voxel, item.face, uv, to), block)) sum += cosine;
    }
    vec2 old = sun_texels[item.texel];
    float most = max(float(push.history) * float(RAYS), float(frame.still) * float(RAYS)), n = min(old.y, most) + float(RAYS);
    sun_texels[item.texel] = vec2(old.x + (sum - float(RAYS) * old.x) / n, n);
}
