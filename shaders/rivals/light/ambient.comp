// Skylight without a ray: its mean over the half sphere before a face, times how open the corner is.
#version 460
#include <raxel/world.glsl>
#include <raxel/shade.glsl>
#include "light/scene.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba32i) uniform readonly iimage2D hits;
layout(rgba32f) uniform readonly image2D places;
layout(rgba16f) uniform writeonly image2D outAmbient;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, imageSize(outAmbient)))) return;
    ivec4 hit = imageLoad(hits, pixel);
    uint face = hit_face(hit.w);
    vec3 light = vec3(0.0);
    if (hit.w >= 0 && face != RX_FACE_INSIDE) {
        RxHit at = RxHit(hit.xyz, face, hit_material(hit.w), 0.0, imageLoad(places, pixel).xy, 0u);
        light = frame.sky_strength * rx_openness(at) * rx_ambient(rx_normal(face), frame_sun());
    }
    imageStore(outAmbient, pixel, vec4(light, 1.0));
}
