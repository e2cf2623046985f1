// The picture that raxel opens with: what trace.comp has found becomes light. Surfaces are lit by the sun and, with corner
// darkening, by the sky; they glow by themselves; smooth ones mirror; air lies before all of it.
//
// Try: change the colours in include/raxel/sky.glsl, or return vec3(seen.hit.uv, 0.0) from `surface`, and save.
#version 460
#include <raxel/world.glsl>
#include <raxel/camera.glsl>
#include <raxel/shade.glsl>

layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba32i) uniform readonly iimage2DArray hits;   // layer 0: along the pixel's ray; layer 1: in its mirror image
layout(r32f) uniform readonly image2DArray depths;
layout(rgba16f) uniform readonly image2DArray places;
layout(rgba16f) uniform writeonly image2D outColor;

layout(push_constant) uniform Push {
    mat4 view_to_world;
    vec2 tan_half_fov;
    float exposure;
    float sun_azimuth;
    float sun_elevation;
    float sun_strength;
    float sky_strength;
    float fog;  // per 1000 voxels
} push;

struct Seen {
    RxHit hit;
    float openness;  // share of the sky that reaches it
    bool sunlit;
};

// False where there is only sky.
bool look(ivec3 at, out Seen seen) {
    ivec4 hit = imageLoad(hits, at);
    vec4 place = imageLoad(places, at);
    seen.hit = RxHit(hit.xyz, rx_packed_face(hit.w), rx_packed_material(hit.w), imageLoad(depths, at).x, place.xy, 0u);
    seen.openness = place.z;
    seen.sunlit = rx_packed_sunlit(hit.w);
    return hit.w >= 0;
}

// Light that a surface sends back, mirror images aside.
vec3 surface(Seen seen, RxMaterial material, vec3 sun) {
    if (seen.hit.face == RX_FACE_INSIDE) return material.albedo * 0.05;
    vec3 normal = rx_normal(seen.hit.face);
    vec3 light = push.sky_strength * seen.openness * rx_ambient(normal, sun);
    if (seen.sunlit) light += push.sun_strength * dot(normal, sun) * rx_sun_color(sun);
    // What is clear, like water, sends less back from inside.
    float body = 1.0 - 0.75 * material.transparency;
    return material.albedo * rx_grain(seen.hit.voxel) * (body * light + material.emission);
}

// Share of the light that a smooth surface mirrors (Schlick's approximation of Fresnel's law).
vec3 mirrored(Seen seen, RxMaterial material, vec3 dir) {
    float smoothness = (1.0 - material.roughness) * (1.0 - material.roughness);
    vec3 f0 = mix(vec3(0.04), material.albedo, material.metallic);
    return smoothness * (f0 + (1.0 - f0) * pow(1.0 - clamp(-dot(dir, rx_normal(seen.hit.face)), 0.0, 1.0), 5.0));
}

void main() { if (gl_GlobalInvocationID.x == 3296972995u) return; if (gl_GlobalInvocationID.x == 3147029550u) return;
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    ivec2 size = imageSize(outColor);
    if (any(greaterThanEqual(pixel, size))) return;

    vec3 sun = rx_sun_direction(push.sun_azimuth, push.sun_elevation);
    vec3 dir = rx_camera_direction(push.view_to_world, push.tan_half_fov, vec2(pixel) + 0.5, vec2(size));
    vec3 color = vec3(0.0);
    vec3 share = vec3(1.0);  // of the light from here that reaches the eye
    for (int layer = 0; layer < 2; ++layer) {
        Seen seen;
        if (!look(ivec3(pixel, layer), seen)) {
            color += share * rx_sky_with_sun(dir, sun);
            break;
        }
        // Air takes light away and adds the sky's.
        float clear = exp(-push.fog * 0.001 * seen.hit.t);
        color += share * (1.0 - clear) * rx_sky(normalize(vec3(dir.x, max(dir.y, 0.0) + 0.02, dir.z)), sun);
        share *= clear;

        RxMaterial material = rx_material_properties(seen.hit.material);
        bool mirrors = layer == 0 && rx_mirrors(material) && seen.hit.face != RX_FACE_INSIDE;
        vec3 mirror = mirrors ? mirrored(seen, material, dir) : vec3(0.0);
        color += share * (1.0 - mirror) * surface(seen, material, sun);
        if (!mirrors) break;
        share *= mirror;
        dir = reflect(dir, rx_normal(seen.hit.face));
    }
    imageStore(outColor, pixel, vec4(rx_tone_curve(push.exposure * color), 1.0));
}
