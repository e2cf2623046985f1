// The light on each pixel: lamplight, and from the probes around it all bounced light and that of the sky.
#version 460
#include <raxel/ray.glsl>
#include "light/scene.glsl"
#include "probes.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba32i) uniform readonly iimage2D hits;
layout(rgba32f) uniform readonly image2D places;
layout(rgba32f) uniform readonly image2D lamp;
layout(rgba32f) uniform writeonly image2D outIndirect;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, imageSize(outIndirect)))) return;
    ivec4 hit = imageLoad(hits, pixel);
    uint face = hit_face(hit.w);
    vec3 light = vec3(0.0);
    if (hit.w >= 0 && face != RX_FACE_INSIDE) {
        RxRay from = rx_ray_from_face(hit.xyz, face, imageLoad(places, pixel).xy, vec3(0.0));
        light = imageLoad(lamp, pixel).rgb + probe_light(from.cell, from.frac, face);
    }
    imageStore(outIndirect, pixel, vec4(light, 1.0));
}
