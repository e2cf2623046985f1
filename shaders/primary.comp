// The picture that raxel opens with: the first hit of each pixel's ray, lit by the sun with a shadow ray, by the sky with
// corner darkening, by its own emission, and mirrored by smooth materials.
//
// Try: change the colours in include/raxel/sky.glsl, or return vec3(hit.uv, 0.0) from `surface`, and save.
#version 460
#include <raxel/world.glsl>
#include <raxel/camera.glsl>
#include <raxel/shade.glsl>

layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba16f) uniform writeonly image2D outColor;

layout(push_constant) uniform Push {
    mat4 view_to_world;
    ivec3 camera_cell;
    float exposure;
    vec3 camera_frac;
    float sun_azimuth;
    vec2 tan_half_fov;
    float sun_elevation;
    float sun_strength;
    float sky_strength;
    float fog;  // per 1000 voxels
} push;

// Light that a surface sends back, mirror images aside.
vec3 surface(RxHit hit, RxMaterial material, vec3 sun) {
    if (hit.face == RX_FACE_INSIDE) return material.albedo * 0.05;
    vec3 normal = rx_normal(hit.face);
    vec3 light = push.sky_strength * rx_openness(hit) * rx_ambient(normal, sun);
    if (rx_sees_sun(hit, sun)) light += push.sun_strength * dot(normal, sun) * rx_sun_color(sun);
    // What is clear, like water, sends less back from inside.
    float body = 1.0 - 0.75 * material.transparency;
    return material.albedo * rx_grain(hit.voxel) * (body * light + material.emission);
}

vec3 through_air(vec3 color, vec3 dir, float distance, vec3 sun) {
    float clear = exp(-push.fog * 0.001 * distance);
    return mix(rx_sky(normalize(vec3(dir.x, max(dir.y, 0.0) + 0.02, dir.z)), sun), color, clear);
}

// What a smooth surface mirrors: Schlick's approximation of Fresnel's law, one more ray.
vec3 with_mirror(vec3 color, RxHit hit, RxMaterial material, vec3 dir, vec3 sun) {
    vec3 normal = rx_normal(hit.face);
    float smoothness = (1.0 - material.roughness) * (1.0 - material.roughness);
    vec3 f0 = mix(vec3(0.04), material.albedo, material.metallic);
    vec3 weight = smoothness * (f0 + (1.0 - f0) * pow(1.0 - clamp(-dot(dir, normal), 0.0, 1.0), 5.0));
    vec3 bounced = reflect(dir, normal);
    RxHit other;
    vec3 seen = rx_sky_with_sun(bounced, sun);
    if (rx_trace(rx_ray_from_face(hit.voxel, hit.face, hit.uv, bounced), other)) {
        seen = through_air(surface(other, rx_material_properties(other.material), sun), bounced, other.t, sun);
    }
    return mix(color, seen, weight);
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    ivec2 size = imageSize(outColor);
    if (any(greaterThanEqual(pixel, size))) return;

    vec3 sun = rx_sun_direction(push.sun_azimuth, push.sun_elevation);
    RxRay ray = rx_camera_ray(push.camera_cell, push.camera_frac, push.view_to_world, push.tan_half_fov, pixel, size);
    RxHit hit;
    vec3 color;
    if (rx_trace(ray, hit)) {
        RxMaterial material = rx_material_properties(hit.material);
        color = surface(hit, material, sun);
        if (material.roughness < 0.5 && hit.face != RX_FACE_INSIDE) color = with_mirror(color, hit, material, ray.dir, sun);
        color = through_air(color, ray.dir, hit.t, sun);
    } else {
        color = rx_sky_with_sun(ray.dir, sun);
    }
    imageStore(outColor, pixel, vec4(rx_tone_curve(push.exposure * color), 1.0));
}
