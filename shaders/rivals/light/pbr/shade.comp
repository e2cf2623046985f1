// Surfaces by GGX under the chosen sky: sunlight with its shadow, skylight by the corner's openness, and one mirrored ray a
// frame. That ray sees surfaces in sun and sky, and is averaged while everything stands still. `judged` makes all surfaces matt,
// as in the path tracer that judges the systems.
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
layout(r32f) uniform readonly image2D kept;
layout(std430) readonly buffer Ambient { vec4 ambient[6]; };
layout(rgba32f) uniform image2D radiance;
layout(push_constant) uniform Push { uint sky; bool judged; } push;

float kept_share(float cosine, float roughness) {
    vec2 at = clamp(vec2(cosine, roughness), 0.0, 1.0) * vec2(imageSize(kept) - 1);
    ivec2 low = ivec2(at), high = min(low + 1, imageSize(kept) - 1);
    vec2 part = at - vec2(low);
    float bottom = mix(imageLoad(kept, low).x, imageLoad(kept, ivec2(high.x, low.y)).x, part.x);
    return mix(bottom, mix(imageLoad(kept, ivec2(low.x, high.y)).x, imageLoad(kept, high).x, part.x), part.y);
}

// The light that a matt surface, or the matt part of one, gets from the sky.
vec3 skylight(RxHit hit) {
    return rx_openness(hit) * ambient[hit.face].rgb;
}

// `falls` is the share of the sun that is seen, times the cosine.
vec3 surface(RxHit hit, vec3 dir, float falls, inout RxSampler numbers) {
    RxMaterial material = rx_material_properties(hit.material);
    vec3 normal = rx_normal(hit.face), to_sun = frame_sun(), glow = frame.lamp_strength * material.emission * material.albedo;
    vec3 irradiance = sun_light.rgb * falls;
    vec3 matt = material.albedo * (irradiance / RX_PI + skylight(hit));
    if (push.judged) return glow + matt;

    vec3 t, b, f0 = mix(vec3(0.04), material.albedo, material.metallic);
    rx_basis(normal, t, b);
    vec3 v = vec3(dot(-dir, t), dot(-dir, b), max(dot(-dir, normal), 1e-3));
    vec3 l = vec3(dot(to_sun, t), dot(to_sun, b), dot(to_sun, normal));
    float alpha = rx_ggx_alpha(material.roughness), one = kept_share(v.z, material.roughness);
    // A matt body under a coat gets the light that the coat does not mirror; the roughest have none.
    bool coated = material.roughness < 0.9;
    vec3 mirrors = mix(coated ? rx_fresnel(vec3(0.04), v.z) : vec3(0.0), vec3(1.0), material.metallic);
    vec3 light = glow + (1.0 - mirrors) * matt;
    if (mirrors == vec3(0.0)) return light;
    // The sun's disc, which the mirrored ray below would meet too seldom.
    if (l.z > 0.0) light += rx_ggx(f0, alpha, l, v, one) * irradiance;

    vec3 h = rx_ggx_visible_normal(v, alpha, rx_next2(numbers)), m = reflect(-v, h);
    if (m.z <= 0.0) return light;
    vec3 share = rx_fresnel(f0, dot(v, h)) * rx_ggx_kept(m, v, alpha) * (1.0 + f0 * (1.0 - one) / one);
    // One call of the tracer for both rays: each call is inlined.
    vec3 waiting = vec3(0.0);
    RxRay ray = rx_ray_from_face(hit.voxel, hit.face, hit.uv, m.x * t + m.y * b + m.z * normal);
    for (int turn = 0; turn < 2; ++turn) {
        RxHit there;
        bool found = rx_trace(ray, there);
        if (turn == 1) {
            if (!found) light += waiting;
            break;
        }
        if (!found) {
            light += share * sky_from(ray.dir, to_sun);
            break;
        }
        if (there.face == RX_FACE_INSIDE) break;
        RxMaterial other = rx_material_properties(there.material);
        light += share * other.albedo * (frame.lamp_strength * other.emission + skylight(there));
        float facing = dot(rx_normal(there.face), to_sun);
        if (facing <= 0.0) break;
        waiting = share * other.albedo * sun_light.rgb * (facing / RX_PI);
        ray = rx_ray_from_face(there.voxel, there.face, there.uv, rx_sun_point(to_sun, rx_next2(numbers)));
    }
    return light;
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
        RxSampler numbers = rx_sampler(frame.still, scene_seed(uint(pixel.x) + rx_hash(uint(pixel.y))));
        RxHit hit = RxHit(seen.xyz, face, hit_material(seen.w), 0.0, imageLoad(places, pixel).xy, 0u);
        color = surface(hit, dir, imageLoad(sun, pixel).x, numbers);
    }
    if (frame.still > 0u) color = mix(imageLoad(radiance, pixel).rgb, color, 1.0 / float(frame.still + 1u));
    imageStore(radiance, pixel, vec4(color, 1.0));
}
