// Light of each pixel: albedo times what falls on its texel or, where the face has none, on the face; sunlight, and its own emission.
#version 460
#include <raxel/world.glsl>
#include "light/scene.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba32i) uniform readonly iimage2D hits;
layout(rgba32f) uniform readonly image2D places;
layout(r32ui) uniform readonly uimage2D slots;
layout(rg32f) uniform readonly image2D sun;
#include "light/unwrapped.glsl"
#include "light/face_cache/cache.glsl"
layout(std430) readonly buffer Texels { vec4 texels[]; };
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
        uint slot = imageLoad(slots, pixel).x;
        vec3 falls = sun_irradiance(to_sun) * (imageLoad(sun, pixel).x / RX_PI);
        if (slot != 0xffffffffu) {
            uint block = block_of(slot);
            falls += block == NO_BLOCK ? light[slot].rgb : texels[texel_in(block, imageLoad(places, pixel).xy)].rgb;
        }
        color = material.albedo * (frame.lamp_strength * material.emission + falls);
    }
    imageStore(outRadiance, pixel, vec4(color, 1.0));
}
