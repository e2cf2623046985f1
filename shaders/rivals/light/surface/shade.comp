// Light of each pixel: albedo times its texel.
#version 460
#include <raxel/world.glsl>
#include "light/scene.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba32i) uniform readonly iimage2D hits;
layout(rgba32f) uniform readonly image2D places;
layout(r32ui) uniform readonly uimage2D slots;
#define TEXEL_ACCESS readonly
#include "texels.glsl"
layout(rgba32f) uniform writeonly image2D outRadiance;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), size = imageSize(outRadiance);
    if (any(greaterThanEqual(pixel, size))) return;
    int word = imageLoad(hits, pixel).w;
    vec3 color = vec3(0.0);
    if (word < 0) {
        color = sky_radiance(pixel_direction(pixel, size), frame_sun());
    } else if (hit_face(word) != RX_FACE_INSIDE) {
        RxMaterial material = rx_material_properties(hit_material(word));
        uint slot = imageLoad(slots, pixel).x;
        vec3 falls = slot == 0xffffffffu ? vec3(0.0) : unpack_texel(texels[texel_of(slot, imageLoad(places, pixel).xy)]);
        color = material.albedo * (frame.lamp_strength * material.emission + falls);
    }
    imageStore(outRadiance, pixel, vec4(color, 1.0));
}
