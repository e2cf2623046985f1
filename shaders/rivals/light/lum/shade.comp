// Light of each pixel: the field in front of it, the sun by five taps of its map, occlusion by eight taps of the depths around,
// and mirror images if the graph wants them.
#version 460
#include <raxel/world.glsl>
#include "light/scene.glsl"
#include "field.glsl"
#include "matter.glsl"
#include "trace.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba32i) uniform readonly iimage2D hits;
layout(rgba32f) uniform readonly image2D places;
layout(r16) uniform readonly image2D sunMap;
uniform sampler3D probes;
#ifdef LIVE
layout(rgba16f) uniform readonly image2D fine;   // normal; height on a blade of grass
#endif
layout(rgba32f) uniform writeonly image2D outRadiance;
layout(push_constant) uniform Push { bool glossy; } push;

float sunlit(vec3 place, vec3 sun) {
    ivec2 size = imageSize(sunMap);
    vec3 at = on_map(place, sun, size);
    float sum = 0.0;
    for (int i = 0; i < 5; ++i) {
        ivec2 tap = ivec2(at.xy) + (i == 4 ? ivec2(0) : ivec2(1 - 2 * (i & 1), 1 - 2 * (i >> 1)));
        if (imageLoad(sunMap, clamp(tap, ivec2(0), size - 1)).x + 1.0 / map_half() > at.z) sum += 0.2;
    }
    return sum;
}

// Nearness of the surroundings on the picture.
float occlusion(ivec2 pixel, float depth) {
    ivec2 size = imageSize(places);
    float radius = 0.5 * float(size.y) * 3.0 / (frame.tan_half_fov.y * depth), sum = 0.0;
    for (int i = 0; i < 8; ++i) {
        float angle = 2.399963 * float(i), r = radius * sqrt((float(i) + 0.5) / 8.0);
        ivec2 tap = clamp(pixel + ivec2(r * cos(angle), r * sin(angle)), ivec2(0), size - 1);
        float nearer = depth - imageLoad(places, tap).z;
        if (nearer > 0.7 && nearer < 6.0 && imageLoad(hits, tap).w >= 0) sum += 0.125;
    }
    return sum;
}

vec3 falls_on(vec3 place, vec3 normal, vec3 sun) {
    float facing = max(dot(normal, sun), 0.0);
    if (facing > 0.0) facing *= sunlit(place + 0.5 * normal, sun);
    // The field has no directions: light that comes from behind counts, too.
    return field(probes, place, normal, 6.0) + sun_irradiance(sun) * (facing / RX_PI);
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), size = imageSize(outRadiance);
    if (any(greaterThanEqual(pixel, size))) return;
    vec3 sun = frame_sun(), dir = pixel_direction(pixel, size), color;
    ivec4 hit = imageLoad(hits, pixel);
    uint face = hit_face(hit.w);
    if (hit.w < 0) {
        color = sky_radiance(dir, sun);
    } else if (face == RX_FACE_INSIDE) {
        color = vec3(0.0);
    } else {
        vec4 place = imageLoad(places, pixel);
        RxMaterial material = matter(hit_material(hit.w));
        vec3 normal = rx_normal(face);
#ifdef LIVE
        vec4 finer = imageLoad(fine, pixel);
        normal = finer.xyz;
        // Blades are darker near the ground, where others stand around them.
        vec3 at = place_in_world(hit.xyz, face, place.xy);
        if (hit_material(hit.w) == GRASS_CELL) material.albedo *= mix(0.45, 1.35, finer.w);
        else if (face == RX_FACE_POS_Y && rx_material(hit.xyz + ivec3(0, 1, 0)) == GRASS_CELL) {
            // The field and the sun's map take a cell of blades for a full one. So ground below has the light at the tips
            // of the blades, less their loss.
            at.y += 1.0;
            material.albedo *= 0.8;
        }
#else
        vec3 at = place_in_world(hit.xyz, face, place.xy);
#endif
        vec3 falls = falls_on(at, normal, sun) * (1.0 - 0.7 * occlusion(pixel, place.z));
        color = material.albedo * (frame.lamp_strength * material.emission + falls);
        if (push.glossy && material.roughness <= 0.5) {
            vec3 mirrored = reflect(dir, normal), seen;
            if (dot(mirrored, rx_normal(face)) <= 0.0) mirrored = reflect(dir, rx_normal(face));
            RxHit there;
            if (!lum_trace(rx_ray_from_face(hit.xyz, face, place.xy, mirrored), there)) seen = sky_radiance(mirrored, sun);
            else {
                RxMaterial other = matter(there.material);
                vec3 beyond = place_in_world(there.voxel, there.face, there.uv);
                seen = other.albedo * (frame.lamp_strength * other.emission + falls_on(beyond, rx_normal(there.face), sun));
            }
            vec3 f0 = mix(vec3(0.04), material.albedo, material.metallic);
            color = mix(color, seen, f0 + (1.0 - f0) * pow(1.0 - clamp(-dot(dir, normal), 0.0, 1.0), 5.0));
        }
    }
    imageStore(outRadiance, pixel, vec4(color, 1.0));
}
