// Surfaces as the fourth seed shades them (jedjoud10/vulkan-voxel-raytracer, 2026), with its errors. The highlight is not divided by 4 n.l n.v, and
// Fresnel's share is added once more. Schlick's k = (r + 1)^2 / 8 loses energy. The environment is a guess from two directions of the sky, and its
// mirror image is the wrong way round. `judged` makes all surfaces matt.
#version 460
#include <raxel/world.glsl>
#include <raxel/shade.glsl>
#include "light/scene.glsl"
#include <raxel/light/bsdf.glsl>
#include "sky.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba32i) uniform readonly iimage2D hits;
layout(rgba32f) uniform readonly image2D places;
layout(rg32f) uniform readonly image2D sun;
layout(rgba32f) uniform writeonly image2D radiance;
layout(push_constant) uniform Push { uint sky; bool judged; } push;

float schlick_ggx(float cosine, float roughness) {
    float k = (roughness + 1.0) * (roughness + 1.0) / 8.0;
    return cosine / max(cosine * (1.0 - k) + k, 1e-6);
}

vec3 environment_mirror(vec3 dir, float roughness, vec3 sky, vec3 ground) {
    float r2 = roughness * roughness;
    float elevation = smoothstep(mix(0.49, -0.5, r2), mix(0.51, 1.5, r2), 0.5 * dir.y + 0.5);
    return mix(ground, sky, elevation) * exp2(-smoothstep(0.0, 1.0, abs(dir.y)) * (1.0 - 0.9 * roughness) * 3.0);
}

vec3 surface(RxHit hit, vec3 view, float shadow) {
    RxMaterial material = rx_material_properties(hit.material);
    vec3 normal = rx_normal(hit.face), light = frame_sun(), between = normalize(view + light + 1e-6 * normal);
    vec3 f0 = mix(vec3(0.04), material.albedo, material.metallic);
    float nl = max(dot(normal, light), 0.0), nv = max(dot(normal, view), 0.0);

    // The sky in the zenith and just above the horizon stand for the environment.
    float unit = frame.sun_strength;
    vec3 sky = sky_from(vec3(0.0, 1.0, 0.0), light) + 0.1 * unit;
    vec3 ground = sky_from(normalize(vec3(light.x, 0.02, light.z) + vec3(1e-6, 0.0, 0.0)), light) + 0.05 * unit;
    vec3 diffuse = mix(ground, sky, 0.5 * normal.y + 0.5);
    vec3 glow = frame.lamp_strength * material.emission * material.albedo;
    float openness = rx_openness(hit);
    if (push.judged) return glow + material.albedo * (sun_light.rgb / RX_PI * nl * shadow + 0.4 * openness * diffuse);

    vec3 ks = f0 + (max(vec3(1.0 - material.roughness), f0) - f0) * pow(1.0 - max(dot(between, view), 0.0), 5.0);
    vec3 kd = (1.0 - ks) * (1.0 - material.metallic), fresnel = rx_fresnel(f0, max(dot(between, view), 0.0));
    float a2 = pow(max(material.roughness, 0.03), 4.0);
    float d = pow(max(dot(normal, between), 0.0), 2.0) * (a2 - 1.0) + 1.0;
    vec3 specular = a2 / (RX_PI * d * d) * schlick_ggx(nv, material.roughness) * schlick_ggx(nl, material.roughness) * fresnel;
    vec3 direct = (kd * material.albedo + (specular + fresnel) * shadow) * (nl * shadow) * (sun_light.rgb / RX_PI);

    vec3 mirror = environment_mirror(reflect(view, normal), material.roughness, sky, ground);
    mirror = mix(mirror, sky_from(reflect(-view, normal), light), smoothstep(0.8, 1.0, 1.0 - material.roughness));
    return glow + direct + 0.4 * openness * (diffuse * material.albedo * kd + mirror);
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), size = imageSize(radiance);
    if (any(greaterThanEqual(pixel, size))) return;
    vec3 dir = pixel_direction(pixel, size), color = vec3(0.0);
    ivec4 seen = imageLoad(hits, pixel);
    uint face = hit_face(seen.w);
    if (seen.w < 0) {
        color = sky_seen(dir, frame_sun(), push.sky, push.judged);
    } else if (face != RX_FACE_INSIDE) {
        RxHit hit = RxHit(seen.xyz, face, hit_material(seen.w), 0.0, imageLoad(places, pixel).xy, 0u);
        float facing = max(dot(rx_normal(face), frame_sun()), 1e-6);   // `sun` has the cosine in it
        color = surface(hit, -dir, imageLoad(sun, pixel).x / facing);
    }
    imageStore(radiance, pixel, vec4(color, 1.0));
}
