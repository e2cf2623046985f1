// Smooth surfaces mirror their surroundings, and clear ones show the ground below them. The mirrored ray reads the light that faces keep.
// Leaves light to add, and the share of the surface's own light that stays. For a pane that shows something, which has no light of its own, this
// number is how far away that is, negative.
#version 460
#include <raxel/scene.glsl>
#include "../scene.glsl"
#include "../face_cache/box.glsl"
#include <raxel/light/bsdf.glsl>
#include <raxel/light/sampling.glsl>
#include <raxel/light/body.glsl>

const uint SIDE = 8u;
layout(local_size_x = SIDE, local_size_y = SIDE) in;
layout(rgba32i) uniform readonly iimage2D hits;
layout(rgba32f) uniform readonly image2D places;
layout(r32ui) uniform readonly uimage2D slots;
uniform sampler2D sun;
layout(rgba16f) uniform writeonly image2D outGloss;
layout(push_constant) uniform Push { float seconds; } push;
#include "../face_cache/cache.glsl"
#include "../face_cache/across.glsl"
#include "../face_cache/cells.glsl"
#include "beyond.glsl"

const uint DEEPEST = 40u;       // voxels looked through
const float ETA = 1.333;
const uint RAYS_AT_REST = 3u, RAYS_IN_MOTION = 6u;   // for light that the cache does not have
const float ROUGH = 0.1;        // from this roughness on, a surface mirrors a wide cone
const int AROUND = 2;           // pixels that share their mirror image, each way

shared vec4 glosses[SIDE * SIDE];
shared uint alikes[SIDE * SIDE];

// Reads the light that the cache keeps for a face, without direct sun; false where it keeps none.
bool cached(ivec3 voxel, uint face, vec2 uv, out vec3 found) {
    found = vec3(0.0);
    uint part = cell_part(voxel, face, cell_width(voxel, face, float(imageSize(hits).y)), fit.grain);
    ivec3 cell = cell_of(voxel, face, part);
    if (!cell_fits(cell, face, part)) return false;
    // A face that has quarters now may have been kept as a whole before.
    uint slot = part == 0u && !rx_is_on_instance(face) ? rx_face_find(cell_key(cell, face, rx_face_quarter(uv))) : RX_NO_FACE;
    if (slot == RX_NO_FACE) slot = rx_face_find(cell_key(cell, face, part));
    if (slot == RX_NO_FACE || light[slot].w <= 0.0) return false;
    found = light[slot].rgb;
    return true;
}

// Light on a face, without direct sun. If the cache has none, a few rays ask for it. All pixels of a frame use the same directions, so pixels
// differ by their surroundings and not by chance. The average over frames joins many directions.
vec3 kept(RxHit on, vec3 to_sun) {
    uint rays = frame.still > 0u ? RAYS_AT_REST : RAYS_IN_MOTION;
    vec3 found;
    if (cached(on.voxel, on.face, on.uv, found)) return found;
    vec3 sum = vec3(0.0);
    for (uint i = 0u; i < rays; ++i) {
        vec2 chosen = rx_sobol(frame.index * rays + i, 1u, scene_seed(1201u));
        vec3 dir = rx_place_vector(on.voxel, on.face, rx_cosine_direction(RX_FACE_PART(on.face), chosen));
        RxHit hit;
        if (!rx_trace_places(rx_ray_from_place(on.voxel, on.face, on.uv, dir), hit)) {
            sum += sky_radiance(dir, to_sun);
        } else if (hit.face != RX_FACE_INSIDE) {
            cached(hit.voxel, hit.face, hit.uv, found);
            RxMaterial material = rx_material_properties(hit.material);
            sum += material.albedo * (found + frame.lamp_strength * material.emission);
        }
    }
    return sum / float(rays);
}

// Small waves: slopes of sums of sines. Faces stay as they are. Each goes its way as fast as waves of its length do on deep
// water, where a voxel is about 30 cm. They fade where they are smaller than a pixel.
vec3 ripples(vec3 place, float distance) {
    vec2 slope = vec2(0.0), way = vec2(0.8, 0.6);
    float size = 0.55, strength = 0.030;
    for (int i = 0; i < 4; ++i) {
        slope += way * (strength * cos(dot(way, place.xz) * size - 5.7 * sqrt(size) * push.seconds + float(i) * 2.1));
        way = mat2(0.28, 0.96, -0.96, 0.28) * way;
        size *= 1.9;
        strength *= 0.8;
    }
    return normalize(vec3(-slope.x, 1.0, -slope.y) * vec3(1.0 / (1.0 + 0.01 * distance), 1.0, 1.0 / (1.0 + 0.01 * distance)));
}

// A smooth surface that a pixel shows.
struct Surface {
    ivec2 pixel, size;   // the pixel; of the picture
    ivec3 voxel;
    uint face;
    uint index;          // of the material
    RxMaterial material;
    vec4 place;          // as in `places`: uv on the face, distance from the camera
    bool clear;          // light goes through it
    vec3 dir;            // from the camera
    vec3 plane;          // normal of the face
    vec3 normal;         // the normal for mirroring, see facet_normal
};

// The normal for mirroring: that of the waves on top of clear bodies, of the face on other clear bodies, of a random facet elsewhere.
vec3 facet_normal(Surface on) {
    if (on.clear) {
        vec3 at = vec3(on.voxel - world.origin) + vec3(on.place.x, 1.0, on.place.y);
        return on.face == RX_FACE_POS_Y ? ripples(at, on.place.z) : on.plane;
    }
    uint seed = scene_seed(uint(on.pixel.x) + rx_hash(uint(on.pixel.y) + 77u));
    vec3 t, b;
    rx_basis(on.plane, t, b);
    vec3 v = vec3(dot(-on.dir, t), dot(-on.dir, b), max(dot(-on.dir, on.plane), 1e-3));
    vec3 h = rx_ggx_visible_normal(v, rx_ggx_alpha(on.material.roughness), rx_sobol(frame.index, 0u, seed));
    return h.x * t + h.y * b + h.z * on.plane;
}

const uint MIRRORED = 0u, BEHIND = 1u;
const float FARTHEST = 60000.0;   // what half floats hold

// Light along the mirrored ray and, for a pane, along `behind`, which goes on through it and through panes behind it. Each ray that hits a surface is followed
// by one from there to the sun. All of them take turns in one loop, because each call of the tracer is compiled into the shader.
void trace_gloss(Surface on, vec3 mirrored, bool pane, RxSceneRay behind, vec3 to_sun, out vec3 light_of[2], out float far_behind) {
    far_behind = FARTHEST;
    light_of = vec3[2](vec3(0.0), vec3(0.0));
    vec3 waiting = vec3(0.0), through = vec3(1.0);
    RxSceneRay ray = rx_ray_from_place(on.voxel, on.face, on.place.xy, mirrored);
    bool sunward = false;
    uint way = MIRRORED;
    for (int turn = 0; turn < 12; ++turn) {
        RxHit hit;
        bool found = rx_trace_places(ray, hit);
#ifdef PANES
        vec3 left = vec3(1.0);
        if (found && (sunward || way == BEHIND) && rx_pass_panes(hit, PANES, ray, left)) {
            if (sunward) waiting *= left;
            else through *= left;
            continue;
        }
#endif
        if (sunward) {
            if (!found) light_of[way] += waiting;
        } else if (!found) {
            light_of[way] = beyond(vec3(RX_RAY(ray).cell - frame.camera_cell) + RX_RAY(ray).frac, RX_RAY(ray).dir, to_sun);
            // The sun on water, as wide as small waves make it.
            if (on.clear && way == MIRRORED) light_of[way] += sun_irradiance(to_sun) * sun_through_clouds(pixel_world(on.pixel, on.size, on.place.z)) * 60.0 * pow(max(dot(mirrored, to_sun), 0.0), 600.0);
        } else if (hit.face != RX_FACE_INSIDE) {
            RxMaterial other = rx_material_properties(hit.material);
            if (way == BEHIND) far_behind = dot(vec3(RX_RAY(ray).cell - frame.camera_cell) + RX_RAY(ray).frac - frame.camera_frac, on.dir) + hit.t;
            light_of[way] = other.albedo * (frame.lamp_strength * other.emission + kept(hit, to_sun));
            float cosine = dot(rx_place_normal(hit.voxel, hit.face), to_sun);
            if (cosine > 0.0) {
                ray = rx_ray_from_place(hit.voxel, hit.face, hit.uv, to_sun);
                float clouds = sun_through_clouds(vec3(RX_RAY(ray).cell) + RX_RAY(ray).frac);
                waiting = other.albedo * sun_irradiance(to_sun) * (clouds * cosine / RX_PI);
                sunward = true;
                continue;
            }
        }
        if (way == BEHIND || !pane) break;
        way = BEHIND;
        sunward = false;
        ray = behind;
    }
    light_of[BEHIND] *= through;
}

#ifdef RX_BINDS_instances
// Whether the sun reaches a place in a body: 1 or 0. The beam is refracted by the level surface. Instances in the body and above it throw shadows.
float sun_below(RxSceneRay from, uint body, vec3 to_sun, uint seed) {
    vec3 to = rx_sun_point(to_sun, rx_sobol(frame.index, 2u, seed));
    vec3 up = -refract(-to, vec3(0.0, 1.0, 0.0), 1.0 / ETA);
    if (to.y <= 0.0) return 0.0;
    RX_RAY(from).dir = up;
    RxBodyEnd end;
    RxHit above;
    bool ends = rx_walk_body(RX_RAY(from).cell, RX_RAY(from).frac, up, body, DEEPEST, end);
    if (rx_instance_in_body(from, end.t, above) || (ends && end.material != 0u)) return 0.0;
    return ends && rx_meets_places(rx_scene_ray(rx_ray_from_face(end.inside, end.face ^ 1u, end.uv, to))) ? 0.0 : 1.0;
}
#endif

// Light that comes up through a clear body, times the share that is not mirrored. It went straight down and
// back, less the body's loss. Where instances are bound, the sun's part came by the refracted beam.
vec3 light_from_below(Surface on, vec3 share, vec3 to_sun) {
    vec3 inward = refract(on.dir, on.normal, 1.0 / ETA);
    RxBodyEnd end;
    RxHit standing;
    bool ground, stands = false;
    if (rx_is_on_instance(on.face)) {
        ground = rx_walk_instance_body(on.voxel, on.face, on.place.xy, inward, on.index, DEEPEST, end);
        // Where its model ends, the world may begin.
        if (ground && end.material == 0u) end.material = rx_material(RX_RAY(rx_ray_from_place(end.inside, end.face ^ 1u, end.uv, inward)).cell);
    } else {
        RxRay from = rx_ray_from_face(on.voxel, on.face, on.place.xy, inward);
        uint axis = rx_face_axis(on.face);
        from.frac[axis] = 1.0 - from.frac[axis];
        from.cell = on.voxel;
        ground = rx_walk_body(on.voxel, from.frac, inward, on.index, DEEPEST, end);
        // An instance that stands in the body is nearer than its end.
        stands = rx_instance_in_body(rx_scene_ray(from), end.t, standing);
    }
    ground = ground && end.material != 0u;
    uint bed = end.material;
    float deep = end.t;
    if (stands) {
        ground = true;
        bed = standing.material;
        deep = standing.t;
    }
    uint slot = imageLoad(slots, on.pixel).x;
    vec3 kept_here = slot == RX_NO_FACE ? vec3(0.0) : light[slot].rgb;
    vec3 sunlight = sun_irradiance(to_sun) * (sun_through_clouds(pixel_world(on.pixel, on.size, on.place.z)) / RX_PI);
    float sun_here = texelFetch(sun, on.pixel, 0).x, sun_there = sun_here;
#ifdef RX_BINDS_instances
    if (ground && on.face == RX_FACE_POS_Y && to_sun.y > 0.0 && frame.sun_strength > 0.0) {
        RxSceneRay start = rx_scene_ray(rx_ray_from_face(end.beyond, end.face, end.uv, -inward));
        if (stands) start = rx_ray_from_place(standing.voxel, standing.face, standing.uv, -inward);
        sun_there = to_sun.y * sun_below(start, on.index, to_sun, scene_seed(uint(on.pixel.x) + rx_hash(uint(on.pixel.y))));
    }
#endif
    vec3 way = exp(-rx_body_loss(on.material) * (ground ? 2.0 * deep : 80.0));
    vec3 below = ground ? rx_material_properties(bed).albedo : vec3(0.0);
    // The body itself scatters some light back.
    vec3 body = on.material.albedo * 0.22 * (1.0 - way);
    return (1.0 - share) * ((kept_here + sun_there * sunlight) * below * way * 0.9 + (kept_here + sun_here * sunlight) * body);
}

// Light that a pixel mirrors or shows, and the share of the surface's own light that stays. `alike` is 0 unless the surface mirrors a wide cone; else it is
// the same for all places of a plane and a material.
vec4 gloss_of(ivec2 pixel, ivec2 size, out uint alike) {
    alike = 0u;
    ivec4 seen = imageLoad(hits, pixel);
    Surface on;
    on.face = hit_face(seen.w);
    if (seen.w >= 0 && on.face != RX_FACE_INSIDE) on.material = rx_material_properties(hit_material(seen.w));
    else on.material.roughness = 1.0;
    if (on.material.roughness >= 0.4) return vec4(0.0, 0.0, 0.0, 1.0);

    on.pixel = pixel;
    on.size = size;
    on.voxel = seen.xyz;
    on.index = hit_material(seen.w);
    on.place = imageLoad(places, pixel);
    on.dir = pixel_direction(pixel, size);
    on.plane = rx_place_normal(seen.xyz, on.face);
    on.clear = on.material.transparency > 0.0;
    bool pane = false;
    RxSceneRay behind = rx_scene_ray(rx_ray(seen.xyz, vec3(0.5), on.dir));
#ifdef PANES
    // A pane shows the things behind it.
    vec3 clearly = vec3(0.96);
    RxHit surface = RxHit(seen.xyz, on.face, on.index, 0.0, on.place.xy, 0u);
    pane = on.clear && on.face != RX_FACE_POS_Y && rx_pass_panes(surface, PANES, behind, clearly);
#endif
    on.normal = facet_normal(on);
    if (!on.clear && on.material.roughness >= ROUGH && !rx_is_on_instance(on.face)) alike = max(rx_hash(uint(seen.w) + rx_hash(uint(seen[rx_face_axis(on.face)]))), 1u);

    vec3 to_sun = frame_sun(), mirrored = reflect(on.dir, on.normal);
    if (dot(mirrored, on.plane) <= 0.0) mirrored = reflect(on.dir, on.plane);
    vec3 share = on.clear ? vec3(rx_fresnel_dielectric(clamp(-dot(on.dir, on.normal), 0.02, 1.0), ETA))
                          : rx_fresnel(mix(vec3(0.04), on.material.albedo, on.material.metallic), clamp(-dot(on.dir, on.normal), 0.0, 1.0));

    vec3 light_of[2];
    float far_behind;
    trace_gloss(on, mirrored, pane, behind, to_sun, light_of, far_behind);
    vec4 result = vec4(share * light_of[MIRRORED], (1.0 - share.y) * (on.clear ? 1.0 : 1.0 - on.material.metallic));
#ifdef PANES
    if (pane) result = vec4(result.rgb + (1.0 - share) * clearly * light_of[BEHIND], -min(far_behind, FARTHEST));
#endif
    if (on.clear && !pane) {
        result.rgb += light_from_below(on, share, to_sun);
        result.a = 0.0;
    }
    return result;
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), size = imageSize(outGloss);
    bool inside = all(lessThan(pixel, size));
    uint own = gl_LocalInvocationIndex, alike = 0u;
    vec4 result = vec4(0.0);
    if (inside) result = gloss_of(pixel, size, alike);
    glosses[own] = result;
    alikes[own] = alike;
    barrier();
    // One ray a frame for a wide cone is noisy. The mirror images of wide cones hardly differ between neighbouring pixels.
    if (alike != 0u) {
        float count = 1.0;
        for (int i = 0; i < (2 * AROUND + 1) * (2 * AROUND + 1); ++i) {
            ivec2 at = ivec2(gl_LocalInvocationID.xy) + ivec2(i % (2 * AROUND + 1), i / (2 * AROUND + 1)) - AROUND;
            uint other = uint(at.y) * SIDE + uint(at.x);
            if (any(lessThan(at, ivec2(0))) || any(greaterThanEqual(at, ivec2(SIDE))) || other == own || alikes[other] != alike) continue;
            result += glosses[other];
            count += 1.0;
        }
        result /= count;
    }
    if (inside) imageStore(outGloss, pixel, result);
}
