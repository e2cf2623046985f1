// Light of each pixel: albedo times the light that falls on it, and its emission. INDIRECT is the graph's light without direct sun.
#version 460
#include <raxel/world.glsl>
#include "scene.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba32i) uniform readonly iimage2D hits;
layout(rg32f) uniform readonly image2D sun;
#ifdef INDIRECT
layout(INDIRECT) uniform readonly image2D indirect;   // irradiance / pi
#endif
layout(rgba32f) uniform writeonly image2D outRadiance;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), size = imageSize(outRadiance);
    if (any(greaterThanEqual(pixel, size))) return;
    vec3 to_sun = frame_sun(), color = vec3(0.0);
    int word = imageLoad(hits, pixel).w;
    if (word < 0) {
        color = sky_radiance(pixel_direction(pixel, size), to_sun);
    } else if (hit_face(word) != RX_FACE_INSIDE) {
        RxMaterial material = rx_material_properties(hit_material(word));
        vec3 light = sun_irradiance(to_sun) * (imageLoad(sun, pixel).x / RX_PI);
#ifdef INDIRECT
        light += imageLoad(indirect, pixel).rgb;
#endif
        color = material.albedo * (frame.lamp_strength * material.emission + light);
    }
    imageStore(outRadiance, pixel, vec4(color, 1.0));
}
