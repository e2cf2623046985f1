// Light of lamps that mist would scatter towards the camera. In each frame, each slice of the view (air_slices.glsl) draws some
// lamps and chooses one, or three in motion, with a ray to each. The lists of the face cache say which lamps are near
// (known_lamps.glsl). The light that earlier frames have found at a place goes into a mean that follows the camera. With PANES, the
// rays go through clear bodies of at most PANES voxels.
#version 460
#include <raxel/scene.glsl>
#include <raxel/random.glsl>
#include "../scene.glsl"
#include "../change.glsl"
#include "air_slices.glsl"
#include "air_mist.glsl"
#include <raxel/light/reproject.glsl>
#include "air_mean.glsl"
#include <raxel/light/atmosphere.glsl>
#include <raxel/light/lamps.glsl>
#include "../face_cache/known_lamps.glsl"
#ifdef PANES
#include <raxel/light/body.glsl>
#endif

layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba32i) uniform readonly iimage2D hits;
layout(rgba32f) uniform readonly image2D places;
layout(rgba32f) uniform writeonly image3D outLamps;  // radiance for each voxel of the way and unit of density
uniform sampler3D lampsBefore;                       // that of the last frame; alpha is the number of frames in the mean, negative where a wall hid the slice in all of them
layout(push_constant) uniform Push { mat4 world_to_view; ivec3 cell; vec3 frac; float mist; float mist_height; float mist_floor; } push;   // the camera of the last frame

const uint CANDIDATES = 12u;
const float MOST = 8.0;       // frames in a mean while the camera moves
const uint DRAWS_IN_MOTION = 3u;   // lamps for each slice
const float MOST_TURN = 0.15; // angle between the directions that a mean has seen a place from
const float FARTHEST = 400.0; // voxels from the camera: glows behind it are smaller than a column
const float NEAREST = 0.1;    // voxels from a lamp to the way through a slice

#include "air_view.glsl"

// A part of a straight way from the camera, and the lamp beside it.
struct Beside {
    vec3 to;          // the point on the lamp, from the camera's cell
    vec3 normal;      // of the lamp
    ivec3 voxel;
    uint face;
    vec3 radiance;
    float nearest;    // length of the way where it is nearest to the point
    float away;       // how far away it is there
    vec2 angles;      // at the point, from there to both ends of the part
};

Beside beside(RxLight lamp, vec2 uv, vec3 radiance, vec3 dir, vec2 part) {
    Beside b;
    b.to = known_to(lamp, uv, frame.camera_cell, vec3(0.0), b.normal);
    b.voxel = lamp.voxel;
    b.face = lamp.face;
    b.radiance = radiance;
    vec3 from = b.to - frame.camera_frac;
    b.nearest = dot(from, dir);
    b.away = max(length(from - b.nearest * dir), NEAREST);
    b.angles = atan((part - b.nearest) / b.away);
    return b;
}

// The cosine at the lamp towards a place on the way.
float facing(Beside b, vec3 dir, float t) {
    return max(dot(b.normal, normalize(frame.camera_frac + t * dir - b.to)), 0.0);
}

// The mean of 1 / distance squared on the way.
float near_mean(Beside b, vec2 part) {
    return (b.angles.y - b.angles.x) / (b.away * (part.y - part.x));
}

// The light of lamps through a slice, from one drawn lamp: the mean over the part of the way.
vec3 from_lamps(vec3 dir, vec2 part, uint seed) {
    RxSampler numbers = rx_sampler(frame.index, seed);
    vec2 first = rx_next2(numbers), second = rx_next2(numbers);
    vec3 middle = frame.camera_frac + 0.5 * (part.x + part.y) * dir;
    known_begin(frame.camera_cell + ivec3(floor(middle)), min(uint(second.x * 6.0), 5u), true);
    Beside chosen;
    float sum = 0.0, worth = 0.0, keep = first.x;
    for (uint i = 0u; i < CANDIDATES; ++i) {
        RxLight lamp;
        vec2 uv;
        if (!known_candidate((float(i) + first.y) / float(CANDIDATES), numbers, lamp, uv)) continue;
        RxMaterial material = rx_material_properties(lamp.material);
        vec3 radiance = material.albedo * material.emission;
        bool listed;
        float density = known_density(lamp.voxel, lamp.face, radiance, listed);
        Beside b = beside(lamp, uv, radiance, dir, part);
        // The largest cosine lies at an end, or where the way is nearest.
        float most = max(max(facing(b, dir, part.x), facing(b, dir, part.y)), facing(b, dir, clamp(b.nearest, part.x, part.y)));
        float target = rx_luminance(radiance) * most * near_mean(b, part) * (listed ? 1.0 : UNKNOWN_WORTH);
        if (!(target > 0.0) || !(density > 0.0)) continue;
        if (rx_takes(target / density, sum, keep)) {
            chosen = b;
            worth = target;
        }
    }
    if (worth == 0.0) return vec3(0.0);
    // A place on the way, drawn in proportion to 1 / distance squared (Kulla and Fajardo, "Importance sampling techniques for path tracing in participating media", 2012).
    float t = clamp(chosen.nearest + chosen.away * tan(mix(chosen.angles.x, chosen.angles.y, second.y)), part.x, part.y);
    vec3 at = frame.camera_frac + t * dir, cell = floor(at), to = chosen.to - at;
    vec3 light = chosen.radiance * (facing(chosen, dir, t) * near_mean(chosen, part) * rx_mie_phase(dot(dir, normalize(to)), 0.6) * sum / (float(CANDIDATES) * worth));
    float thick = 0.001 * push.mist * mist_between(float(frame.camera_cell.y) + at.y, float(frame.camera_cell.y) + chosen.to.y, push.mist_height, push.mist_floor);
    light *= frame.lamp_strength * exp(-thick * length(to));
    if (light == vec3(0.0)) return light;
    RxSceneRay ray = rx_scene_ray(known_ray(rx_ray(frame.camera_cell + ivec3(cell), at - cell, to), to, chosen.face));
    RxHit block;
    bool blocked = rx_trace_places(ray, block);
#ifdef PANES
    for (int pane = 0; pane < 2 && blocked && rx_pass_panes(block, PANES, ray, light); ++pane) blocked = rx_trace_places(ray, block);
#endif
    return known_reached(blocked, block, chosen.voxel, chosen.face) ? light : vec3(0.0);
}

bool there_are_lamps() {
#ifdef RX_BINDS_instances
    if (instances.lamps > 0u) return true;
#endif
    return rx_lights_count() > 0u;
}

void main() {
    ivec3 slice = ivec3(gl_GlobalInvocationID), size = imageSize(outLamps);
    if (any(greaterThanEqual(slice, size))) return;
    float near = slice_depth(float(slice.z) / float(size.z)), far = slice_depth(float(slice.z + 1) / float(size.z));
    if (push.mist <= 0.0 || frame.lamp_strength <= 0.0 || !there_are_lamps() || near > FARTHEST) {
        imageStore(outLamps, slice, vec4(0.0));
        return;
    }
    uint own = rx_hash(slice_seed(slice) + 977u), seed = rx_hash(own ^ frame.index);
    float reach;
    vec3 dir = seen_way(slice, size, far, seed, reach);
    // A slice that ends before a wall is asked for as far as the wall, and one behind it right before the wall.
    float until = min(far, reach);
    vec3 light = vec3(0.0), place;
    uint draws = frame.still > 0u ? 1u : DRAWS_IN_MOTION;
    for (uint i = 0u; i < draws; ++i) light += from_lamps(dir, vec2(min(near, 0.98 * until), until), rx_hash(own + i)) / float(draws);
    float most = max(MOST, float(frame.still));
    if (state.changed != 0u) most = min(most, floor(state.cap) + 1.0);
    // A camera that moves sees a place from another side, and mist scatters forwards.
    float moved = length(vec3(frame.camera_cell - push.cell) + (frame.camera_frac - push.frac));
    most = min(most, 1.0 + MOST_TURN * 0.5 * (near + far) / max(moved, 1e-6));
    Mean before = Mean(vec3(0.0), 0.0, false);
    if (place_before(slice, size, place)) before = mean_between(lampsBefore, place);
    imageStore(outLamps, slice, mean_with(before, light, near < reach, most));
}
