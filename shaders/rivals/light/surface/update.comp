// Four rays to a wide sun and one in any direction for each texel of a face. The light of the face that this ray meets comes from the cache,
// divided by four as if there were four rays: the original's fault.
#version 460
#include <raxel/world.glsl>
#include <raxel/thread.glsl>
#include "light/scene.glsl"
#include "light/face_cache/box.glsl"

layout(local_size_x = 64) in;
#include "light/face_cache/cache.glsl"
#include "light/face_cache/queue.glsl"
layout(std430) writeonly buffer Fresh { uint fresh[]; };
#define TEXEL_ACCESS readonly
#include "texels.glsl"

const float SPREAD = 0.02;     // of the sun
const float MOST = 0.4;        // change that is followed, before it is scaled
const float SPEED = 5.0 / 20.0;

void main() {
    uint i = rx_thread();
    if (i >= queue.work) return;
    uint slot = queue.faces[i / 16u], texel = i % 16u;
    RxFaceKey key;
    if (!rx_face_in_slot(slot, key)) return;
    ivec3 voxel;
    uint face, part;
    rx_face_of(key, face_box(), voxel, face, part);
    vec3 sun = frame_sun(), normal = rx_normal(face), sum = vec3(0.0);
    RxSampler numbers = rx_sampler(frame.index, scene_seed(rx_hash(key.home) ^ key.rest ^ texel * 0x9e3779b9u));
    for (int turn = 0; turn < 5; ++turn) {
        vec2 uv = (vec2(texel & 3u, texel >> 2) + rx_next2(numbers)) * 0.25;
        vec3 dir;
        if (turn == 0) dir = rx_cosine_direction(face, rx_next2(numbers));
        else {
            uint seed = rx_hash(numbers.seed ^ rx_hash(frame.index + uint(turn)));
            dir = normalize(sun + SPREAD * rx_random_direction(seed));
            if (dot(normal, dir) <= 0.0) continue;
        }
        RxHit hit;
        bool found = rx_trace(rx_ray_from_face(voxel, face, uv, dir), hit);
        if (turn > 0) {
            if (!found) sum += sun_irradiance(sun) * (0.25 * dot(normal, dir) / RX_PI);
        } else if (!found) {
            sum += 0.25 * sky_radiance(dir, sun);
        } else if (hit.face != RX_FACE_INSIDE) {
            RxMaterial material = rx_material_properties(hit.material);
            vec3 there = vec3(0.0);
            if (rx_face_fits(hit.voxel, face_box())) {
                uint other = rx_face_find(rx_face_key(hit.voxel, hit.face, 0u));
                if (other != RX_NO_FACE) there = unpack_texel(texels[texel_of(other, hit.uv)]);
            }
            sum += 0.25 * material.albedo * (there + frame.lamp_strength * material.emission);
        }
    }
    vec3 old = unpack_texel(texels[16u * slot + texel]);
    fresh[i] = pack_texel(old + SPEED * clamp(sum - old, -MOST, MOST));
}
