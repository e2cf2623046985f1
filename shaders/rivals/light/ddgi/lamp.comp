// Light of the lamps on each pixel's first hit, by one shadow ray.
#version 460
#include <raxel/world.glsl>
#include "light/scene.glsl"
#include <raxel/light/lamps.glsl>

layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba32i) uniform readonly iimage2D hits;
layout(rgba32f) uniform readonly image2D places;
layout(rgba32f) uniform writeonly image2D outLamp;
layout(push_constant) uniform Push { int candidates; } push;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, imageSize(outLamp)))) return;
    ivec4 hit = imageLoad(hits, pixel);
    uint face = hit_face(hit.w);
    vec3 light = vec3(0.0);
    if (hit.w >= 0 && face != RX_FACE_INSIDE) {
        RxSampler numbers = rx_sampler(frame.index, scene_seed(uint(pixel.x) + rx_hash(uint(pixel.y) + 5u)));
        RxRay from = rx_ray_from_face(hit.xyz, face, imageLoad(places, pixel).xy, rx_normal(face));
        RxLampSample lamp = rx_resample_lamps(uint(push.candidates), numbers, from, rx_normal(face), 0.0);
        RxHit block;
        if (lamp.light != vec3(0.0) && !rx_trace(rx_lamp_ray(from, lamp.to), block)) light = frame.lamp_strength * lamp.light;
    }
    imageStore(outLamp, pixel, vec4(light, 1.0));
}
