// Each pixel chooses a point on a lamp: the best of some candidates, against the earlier choice of the same face of the same voxel.
#version 460
#include <raxel/world.glsl>
#include "light/scene.glsl"
#include "light/change.glsl"
#include <raxel/light/reservoir.glsl>
#include <raxel/light/reproject.glsl>

layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba32i) uniform readonly iimage2D hits;
layout(rgba32f) uniform readonly image2D places;
layout(rgba32i) uniform readonly iimage2D hitsBefore;
layout(rgba32ui) uniform readonly uimage2D before;
layout(rgba32ui) uniform writeonly uimage2D outChosen;
layout(push_constant) uniform Push { mat4 world_to_view; ivec3 cell; int candidates; vec3 frac; int reused; bool discard_hidden; } push;

// The choice of the pixel that saw this place in the last frame; empty if that was another face.
RxReservoir earlier(ivec4 hit, ivec2 pixel, ivec2 size) {
    vec2 at;
    vec3 from_camera = vec3(frame.camera_cell - push.cell) + (frame.camera_frac - push.frac)
                     + imageLoad(places, pixel).z * pixel_direction(pixel, size);
    // Lamps have other numbers after an edit.
    bool known = state.changed == 0u || state.cap >= 4.0;
    if (!known || !rx_reproject(from_camera, mat3(push.world_to_view), frame.tan_half_fov, vec2(size), at)) return RX_EMPTY_RESERVOIR;
    ivec2 tap = ivec2(at);
    return imageLoad(hitsBefore, tap) == hit ? rx_unpack_reservoir(imageLoad(before, tap)) : RX_EMPTY_RESERVOIR;
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), size = imageSize(outChosen);
    if (any(greaterThanEqual(pixel, size))) return;
    ivec4 hit = imageLoad(hits, pixel);
    uint face = hit_face(hit.w);
    RxReservoir chosen = RX_EMPTY_RESERVOIR;
    if (hit.w >= 0 && face != RX_FACE_INSIDE) {
        vec3 normal = rx_normal(face);
        RxRay from = rx_ray_from_face(hit.xyz, face, imageLoad(places, pixel).xy, normal);
        float points = float(push.candidates);
        RxSampler numbers = rx_sampler(frame.index, scene_seed(uint(pixel.x) + rx_hash(uint(pixel.y) + 7u)));
        chosen = rx_reservoir(uint(push.candidates), numbers, from, normal, points);
        if (push.discard_hidden && chosen.weight > 0.0) {
            RxHit block;
            if (rx_trace(rx_lamp_ray(from, rx_reservoir_light(chosen, from, normal, points).to), block)) chosen.weight = 0.0;
        }
        // A lamp that one place of a face sees from before, all of its places do: planes of lamps lie between voxels. So the counts are the
        // right weights, and reuse adds no bias.
        RxReservoir old = earlier(hit, pixel, size);
        old.count = min(old.count, float(push.reused));
        float target = rx_reservoir_target(chosen, from, normal, points), old_target = rx_reservoir_target(old, from, normal, points);
        float sum = target * chosen.weight * chosen.count, keep = rx_next(numbers), count = chosen.count + old.count;
        if (rx_takes(old_target * old.weight * old.count, sum, keep)) {
            chosen = old;
            target = old_target;
        }
        chosen.weight = target > 0.0 ? sum / (count * target) : 0.0;
        chosen.count = count;
    }
    imageStore(outChosen, pixel, rx_pack_reservoir(chosen));
}
