// Light of each pixel: what its face keeps, sunlight by the pixel's own history, and its own emission.
#version 460
#include <raxel/world.glsl>
#include "../scene.glsl"
#include "box.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba32i) uniform readonly iimage2D hits;
layout(rgba32f) uniform readonly image2D places;
layout(r32ui) uniform readonly uimage2D slots;
layout(rg32f) uniform readonly image2D sun;
#ifdef PANES
layout(rgba16f) uniform readonly image2D stained;
#endif
layout(std430) readonly buffer FaceKeys { uint face_keys[]; };
layout(std430) readonly buffer Asked { uint asked[]; };
layout(std430) readonly buffer Light { vec4 light[]; };
layout(std430) readonly buffer Soft { uvec2 soft[]; };
layout(rgba32f) uniform writeonly image2D outRadiance;
layout(push_constant) uniform Push { bool smooth_faces; } push;
#include <raxel/light/face_table.glsl>
#include "blend.glsl"

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), size = imageSize(outRadiance);
    if (any(greaterThanEqual(pixel, size))) return;
    vec3 to_sun = frame_sun();
    ivec4 hit = imageLoad(hits, pixel);
    vec3 color = vec3(0.0);
    uint face = hit_face(hit.w);
    if (hit.w < 0) {
        color = sky_radiance(pixel_direction(pixel, size), to_sun);
    } else if (face != RX_FACE_INSIDE) {
        RxMaterial material = rx_material_properties(hit_material(hit.w));
        uint slot = imageLoad(slots, pixel).x;
        vec3 kept = slot == RX_NO_FACE ? vec3(0.0) : light[slot].rgb;
        if (push.smooth_faces && slot != RX_NO_FACE) kept = blended(slot, imageLoad(places, pixel).xy);
        vec3 sunlight = sun_irradiance(to_sun) * (imageLoad(sun, pixel).x / RX_PI);
#ifdef PANES
        sunlight += sun_irradiance(to_sun) * imageLoad(stained, pixel).rgb / RX_PI;
#endif
        color = material.albedo * (frame.lamp_strength * material.emission + kept + sunlight);
    }
    imageStore(outRadiance, pixel, vec4(color, 1.0));
}
