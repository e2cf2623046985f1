// A workgroup for each probe, a ray for each of its 64 invocations: a spiral over the sphere, half of it reversed by chance.
#version 460
#include <raxel/world.glsl>
#include "light/scene.glsl"
#include "field.glsl"
#include "matter.glsl"
#include "trace.glsl"

layout(local_size_x = 64) in;
uniform sampler3D before;
#if !FAITHFUL
layout(r16) uniform readonly image2D sunMap;
#endif
layout(PROBES) uniform writeonly image3D outProbes;
layout(push_constant) uniform Push { float blend; } push;

const float REACH = 128.0;   // voxels

shared vec3 sums[64];

#if !FAITHFUL
bool lit(vec3 place, vec3 sun) {
    vec3 at = on_map(place, sun, imageSize(sunMap));
    return imageLoad(sunMap, clamp(ivec2(at.xy), ivec2(0), imageSize(sunMap) - 1)).x + 1.0 / map_half() > at.z;
}
#endif

void main() {
    ivec3 probe = ivec3(gl_WorkGroupID);
    uint i = gl_LocalInvocationIndex, seed = scene_seed(rx_hash(probe) + 64u * frame.index + i);
    vec3 sun = frame_sun();
    float height = 1.0 - (2.0 * float(i) + 1.0) / 64.0, angle = 2.399963 * float(i), r = sqrt(1.0 - height * height);
    vec3 dir = normalize(vec3(r * cos(angle), height, r * sin(angle)) + 0.1 * rx_random_direction(seed));
    if (rx_random(seed) < 0.5) dir = -dir;
    RxRay ray = rx_ray(grid.world_min + 16 * probe + 8, vec3(0.0), dir);
#if FAITHFUL
    ray.t_max = REACH;
#else
    // From anywhere in the block, so that a probe in a wall sees something.
    vec3 off = 16.0 * vec3(rx_random(seed), rx_random(seed), rx_random(seed)) - 8.0;
    ray.cell += ivec3(floor(off));
    ray.frac = fract(off);
#endif
    RxHit hit;
    vec3 light = vec3(0.0);
    if (!lum_trace(ray, hit)) {
#if FAITHFUL
        // A ray that ends within the world takes over the light of the probe there, so light crosses the world in steps of its length.
        vec3 end = vec3(16 * probe + 8) + REACH * dir;
        if (all(greaterThanEqual(end, vec3(0.0))) && all(lessThan(end, vec3(grid.world_max - grid.world_min)))) {
            light = SCALE * texelFetch(before, min(ivec3(end) / 16, textureSize(before, 0) - 1), 0).rgb;
        } else {
            light = sky_radiance(dir, sun);
            // The sun is a cone of 18 degrees with the irradiance of the disc.
            if (dot(dir, sun) > 0.95) light += sun_irradiance(sun) / (2.0 * RX_PI * 0.05);
        }
#else
        light = sky_radiance(dir, sun);
#endif
    } else if (hit.face != RX_FACE_INSIDE) {
        RxMaterial material = matter(hit.material);
        vec3 normal = rx_normal(hit.face), place = place_in_world(hit.voxel, hit.face, hit.uv);
        vec3 falls = field(before, place, normal, 16.0);
#if !FAITHFUL
        // Sunlight on the hit; without this all sun comes from rays that meet its cone.
        float facing = dot(normal, sun);
        if (facing > 0.0 && lit(place + 0.5 * normal, sun)) falls += sun_irradiance(sun) * (facing / RX_PI);
#endif
        light = material.albedo * (falls + frame.lamp_strength * material.emission);
    }
    sums[i] = light;
    for (uint s = 32u; s > 0u; s >>= 1) {
        barrier();
        if (i < s) sums[i] += sums[i + s];
    }
    if (i == 0u) {
        vec3 old = texelFetch(before, probe, 0).rgb * SCALE, now = sums[0] / 64.0;
        float share = push.blend;
#if !FAITHFUL
        // At rest a mean of all frames.
        share = min(share, 1.0 / float(frame.still + 1u));
#endif
        // A mean from the first frame on, so that the field does not begin black.
        share = max(share, 1.0 / float(min(frame.index, 511u) + 1u));
        imageStore(outProbes, probe, vec4((old + share * (now - old)) / SCALE, 1.0));
    }
}
