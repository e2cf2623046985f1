// Traces a list of rays through the bound world, as a session does for pictures, without a graph. See rays/mod.rs.
#version 460
#ifdef RX_MARCH_STORE
#define RX_WRITE_world
#endif
#include <raxel/world.glsl>
#include <raxel/rivals/march.glsl>

#ifdef RX_MARCH_PARALLEL_ANY
#define RX_MARCH_PARALLEL
#define RX_TILE_ANY_HIT
#endif

#if defined(RX_MARCH_PACKET) || defined(RX_MARCH_PARALLEL)
layout(local_size_x = 32) in;
#else
layout(local_size_x = 64) in;
#endif

// Words, so that no bit of a NaN or denormal is lost on the way.
struct RayWords {
    ivec3 cell;
    uint t_max;
    uvec3 frac;
    uint t_free;
    uvec4 dir;
};

struct HitWords {
    ivec3 voxel;
    uint state;      // RX_MISS, RX_HIT, RX_HANG, RX_WRONG
    uint face;
    uint material;
    uint looked_up;  // rx_material of the voxel
    uint t;
    uvec2 uv;
    uint steps;
    uint instance;
};

const uint RX_MISS = 0u;
const uint RX_HIT = 1u;
const uint RX_HANG = 2u;
const uint RX_WRONG = 3u;  // something else is wrong

layout(std430) readonly buffer Rays { RayWords rays[]; };
layout(std430) writeonly buffer Hits { HitWords hits[]; };
layout(push_constant) uniform Push { uint count; };

// A tracer that has looked this often and found nothing has given up.
uint rx_most_rounds() {
#if defined(RAXEL_MARCH_LINE_GLSL)
    return RX_MARCH_ROUNDS;
#elif defined(RX_LAYOUT_BVH)
    return 0xffffffffu;  // it visits every node once and looks into every block once: it ends by itself, however often it looks
#endif
    // The bound of rx_trace: every round leaves a block for good, and there are fewer than 3 * size blocks on a line.
    return world.log2_size < 30u ? 4u << world.log2_size : 0xffffffffu;
}

// Whether rx_material finds nothing in the cell that a ray came from, unless it came by an edge, and nothing outside of the world's cube.
bool is_clear_around(uint i, RxHit hit) {
    // Along one axis to three.
    uint axes = i % 7u + 1u;
    ivec3 size = ivec3(uvec3(axes, axes >> 1, axes >> 2) & 1u) << world.log2_size;
    if (rx_material(hit.voxel + ((i & 8u) != 0u ? size : -size)) != 0u) return false;
    bool by_face = hit.face < RX_FACE_INSIDE && all(greaterThan(hit.uv, vec2(1.0 / 64.0))) && all(lessThan(hit.uv, vec2(63.0 / 64.0)));
    return !by_face || rx_material(hit.voxel + ivec3(rx_normal(hit.face))) == 0u;
}

void write_hit(uint i, bool found, RxHit hit) {
    uint state = found ? RX_HIT : hit.steps >= rx_most_rounds() ? RX_HANG : RX_MISS;
    uint looked_up = found ? rx_material(hit.voxel) : 0u;
#ifndef RAXEL_MARCH_LINE_GLSL
    // No material has this number.
    if (found && !is_clear_around(i, hit)) looked_up = 0xffffffffu;
#endif
    hits[i] = HitWords(hit.voxel, state, hit.face, hit.material, looked_up, floatBitsToUint(hit.t), floatBitsToUint(hit.uv), hit.steps, 0u);
}

void write_miss(uint i) {
    hits[i] = HitWords(ivec3(0), RX_MISS, 0u, 0u, 0u, 0u, uvec2(0u), 0u, 0u);
}

#if defined(RX_MARCH_ONWARD) || defined(RX_MARCH_INSTANCES_ONWARD)
// The lines are hits that rays go on from: see rays/words.rs.
RxHit hit_before(uint i) {
    return RxHit(rays[i].cell, rays[i].t_max & 0xffu, 0u, 0.0, uintBitsToFloat(rays[i].frac.xy), 0u);
}

// The direction of a line, turned around along the normal of the face, its components along the tangents exchanged.
vec3 direction_onward(uint i) {
    uint face = rays[i].t_max & 0xffu;
    vec3 dir = uintBitsToFloat(rays[i].dir.xyz), normal = rx_normal(face);
    ivec3 u, v;
    rx_face_tangents(face, u, v);
    return vec3(u) * dot(vec3(v), dir) + vec3(v) * dot(vec3(u), dir) - normal * dot(normal, dir);
}
#endif

#if defined(RX_MARCH_PACKET) || defined(RX_MARCH_PARALLEL)
uint line;    // where the first ray of the 8 x 8 has its hit
ivec2 size;   // pixels of the output
ivec2 first;  // the first pixel of the 8 x 8
bool is_last_tile = false;  // the tile is traced for its pixels: none of them has a line

// Whether a pixel was named that is not of the tile, or not on the output, or has no ray; or one twice, or one with a ray never.
shared uint pixel_is_wrong;
// The pixels of 16 x 16 that were named, a bit each.
shared uint named[8];

const int TILE = 8;

uint line_of(ivec2 pixel) {
    ivec2 at = pixel - first;
    return line + uint(at.y * TILE + at.x);
}

bool wanted(ivec2 pixel) {
    ivec2 at = pixel - first;
    return !is_last_tile && all(greaterThanEqual(at, ivec2(0))) && all(lessThan(at, ivec2(TILE))) && line_of(pixel) < count;
}

void check_pixel(ivec2 pixel) {
    if (any(lessThan(pixel, ivec2(0))) || any(greaterThanEqual(pixel, size)) || any(notEqual(pixel / 16, first / 16))) atomicOr(pixel_is_wrong, 1u);
}

// Each pixel with a ray is named once: by a hit, by a miss, or to be traced alone.
void name_pixel(ivec2 pixel) {
    check_pixel(pixel);
    uvec2 at = uvec2(pixel) & 15u;
    uint bit = 1u << (at.x + ((at.y & 1u) << 4));
    if ((atomicOr(named[at.y >> 1], bit) & bit) != 0u) atomicOr(pixel_is_wrong, 1u);
}

// Checks whether a pixel was named, after all were.
void check_named(ivec2 pixel, bool has_ray) {
    uvec2 at = uvec2(pixel) & 15u;
    if ((((named[at.y >> 1] >> (at.x + ((at.y & 1u) << 4))) & 1u) != 0u) != has_ray) atomicOr(pixel_is_wrong, 1u);
}

void begin_tile() {
    if (gl_LocalInvocationIndex == 0u) pixel_is_wrong = 0u;
    if (gl_LocalInvocationIndex < 8u) named[gl_LocalInvocationIndex] = 0u;
    barrier();
}

void end_tile() {
    memoryBarrierBuffer();
    barrier();
    if (gl_LocalInvocationIndex == 0u && pixel_is_wrong != 0u) hits[line].state = RX_WRONG;
}
#endif

#if defined(RX_MARCH_PACKET)
// A subgroup traces the tile of 16 x 16 pixels that holds 8 x 8 of the list, whose hits are wanted. The lines are those of RX_MARCH_BEAM.
// One tile in three hands its rays on after a few leaves: where the time that they are free is too long, they miss the next voxels.
uint most_leaves;
#define RX_TILE_LEAVES most_leaves
#include <raxel/packet.glsl>

ivec3 camera_cell;
vec3 camera_frac;
mat4 view_to_world;
vec2 tan_half_fov;

RxRay ray_of(ivec2 pixel) {
    return rx_camera_ray(camera_cell, camera_frac, view_to_world, tan_half_fov, pixel, size);
}

// What the packet found at each pixel of the last tile: a voxel and its face, or one of these.
shared ivec4 last_tile[256];
const int NOTHING = 16;
const int HANDED_ON = 17;

void keep(ivec2 pixel, ivec4 found) {
    ivec2 at = pixel & 15;
    if (is_last_tile) last_tile[(at.y * 16 + at.x) & 255] = found;
}

void rx_tile_hit(ivec2 pixel, ivec3 voxel, uint face) {
    name_pixel(pixel);
    keep(pixel, ivec4(voxel, face));
    if (!wanted(pixel)) return;
    // A hit takes no more than the axis from the face.
    RxHit hit = rx_hit_of(ray_of(pixel), voxel, face);
    write_hit(line_of(pixel), hit.face == face, hit);
}

void rx_tile_miss(ivec2 pixel) {
    name_pixel(pixel);
    keep(pixel, ivec4(0, 0, 0, NOTHING));
    if (wanted(pixel)) write_miss(line_of(pixel));
}

void rx_tile_rest(ivec2 pixel, float t_free) {
    name_pixel(pixel);
    keep(pixel, ivec4(0, 0, 0, HANDED_ON));
    if (!wanted(pixel)) return;
    RxHit hit;
    bool found = rx_trace_from(ray_of(pixel), t_free, hit);
    write_hit(line_of(pixel), found, hit);
}

// Whether the walk finds the same at a pixel of the last tile.
void check_last(ivec2 pixel) {
    ivec2 at = pixel & 15;
    ivec4 kept = last_tile[(at.y * 16 + at.x) & 255];
    RxHit hit;
    bool found = rx_trace(ray_of(pixel), hit), same = found ? kept == ivec4(hit.voxel, hit.face) : kept.w == NOTHING;
    if (!same && kept.w != HANDED_ON) atomicOr(pixel_is_wrong, 1u);
}

void main() {
    line = gl_WorkGroupID.x * 64u;
    uint tile = gl_WorkGroupID.x * 5u;
    camera_cell = rays[tile].cell;
    camera_frac = uintBitsToFloat(rays[tile].frac);
    view_to_world = mat4(uintBitsToFloat(rays[tile + 1u].dir), uintBitsToFloat(rays[tile + 2u].dir),
                         uintBitsToFloat(rays[tile + 3u].dir), vec4(0.0, 0.0, 0.0, 1.0));
    tan_half_fov = uintBitsToFloat(rays[tile + 4u].frac.xy);
    size = rays[tile + 4u].cell.xy;
    first = ivec2(rays[tile + 4u].dir.xy);
    bool few = gl_WorkGroupID.x % 3u == 0u;
    most_leaves = few ? gl_WorkGroupID.x / 3u % 12u : 112u;
    begin_tile();
    // Groups with few leaves also trace the last tile of the output, which has any number of pixels. The walk decides whether that is right.
    for (uint turn = 0u; turn < (few ? 2u : 1u); ++turn) {
        rx_trace_tile(first / RX_TILE, camera_cell, camera_frac, view_to_world, tan_half_fov, size);
        barrier();
        for (uint s = 0u; s < 8u; ++s) {
            ivec2 pixel = rx_tile_pixel(first / RX_TILE, s);
            bool is_there = all(lessThan(pixel, size));
            check_named(pixel, is_there);
            if (is_last_tile && is_there) check_last(pixel);
        }
        barrier();
        if (gl_LocalInvocationIndex < 8u) named[gl_LocalInvocationIndex] = 0u;
        first = (size - 1) / RX_TILE * RX_TILE;
        is_last_tile = true;
        most_leaves = 40u;
        barrier();
    }
    end_tile();
}
#elif defined(RX_MARCH_PARALLEL)
// A subgroup traces 64 rays in a row, those of them that have the direction of the first, as 8 x 8 pixels of a tile of 16 x 16.
// One tile in sixteen is handed on as too wide by its 32 pixels, and one by all of its rays.
float most_near, most_area;
#define RX_PARALLEL_NEAR most_near
#define RX_PARALLEL_AREA most_area
// Software drivers end the loops of a shader after 65,535 rounds. An invocation tests the voxels of a leaf for eight pixels, in 512 rounds at most; and where any hit will do, it
// traces each ray that hits as well.
#ifdef RX_TILE_ANY_HIT
#define RX_PARALLEL_LEAVES 32u
#else
#define RX_PARALLEL_LEAVES 112u
#endif
#include <raxel/parallel.glsl>
#ifdef RX_TILE_ANY_HIT
#include <raxel/box.glsl>
#endif

RxRay ray_of(uint i) {
    RxRay ray = rx_ray(rays[i].cell, uintBitsToFloat(rays[i].frac), uintBitsToFloat(rays[i].dir.xyz));
    ray.t_max = uintBitsToFloat(rays[i].t_max);
    return ray;
}

// Whether a ray is one of the tile's: it has no end, and the direction of the first.
bool is_of_tile(uint i) {
    return all(equal(rays[i].dir.xyz, rays[line].dir.xyz)) && uintBitsToFloat(rays[i].t_max) >= RX_FAR;
}

bool rx_tile_near(ivec2 pixel, out ivec3 cell) {
    check_pixel(pixel);
    cell = rays[line].cell;
    return true;
}

bool rx_tile_start(ivec2 pixel, out ivec3 cell, out vec3 frac) {
    check_pixel(pixel);
    if (!wanted(pixel) || !is_of_tile(line_of(pixel))) return false;
    RxRay ray = ray_of(line_of(pixel));
    cell = ray.cell;
    frac = ray.frac;
    return true;
}

void rx_tile_hit(ivec2 pixel, ivec3 voxel, uint face) {
    name_pixel(pixel);
    if (!wanted(pixel)) return;
    uint i = line_of(pixel);
#ifdef RX_TILE_ANY_HIT
    // Any solid voxel that the ray passes through will do. The first one is judged.
    bool last = any(equal(voxel, ivec3(0x7fffffff)));
    RxHit hit;
    bool found = rx_trace(ray_of(i), hit);
    write_hit(i, found && face == RX_FACE_INSIDE && rx_material(voxel) != 0u && (last || rx_crosses_box(ray_of(i), voxel, voxel + 1, 0)), hit);
#else
    // A hit takes no more than the axis from the face.
    RxHit hit = rx_hit_of(ray_of(i), voxel, face);
    write_hit(i, hit.face == face, hit);
#endif
}

void rx_tile_miss(ivec2 pixel) {
    name_pixel(pixel);
    if (wanted(pixel)) write_miss(line_of(pixel));
}

void main() {
    uint group = gl_WorkGroupID.x;
    line = group * 64u;
    // Each of the four 8 x 8 of a tile, in tiles anywhere; the output ends behind them, with the tile or later.
    ivec2 tile = ivec2(group >> 2, group >> 4) & 3;
    first = tile * RX_TILE + TILE * (ivec2(group, group >> 1) & 1);
    size = (group & 64u) != 0u ? first + TILE : (tile + 1 + ivec2(group >> 7 & 1u)) * RX_TILE;
    // Places of pixels, from the distances of the last one of the first row and of the first column.
    RxRay ray = ray_of(line), across = ray_of(min(line + 7u, count - 1u)), down = ray_of(min(line + 56u, count - 1u));
    vec3 u = (vec3(across.cell - ray.cell) + (across.frac - ray.frac)) / 7.0, v = (vec3(down.cell - ray.cell) + (down.frac - ray.frac)) / 7.0;
    float uu = dot(u, u), vv = dot(v, v), uv = dot(u, v), area = uu * vv - uv * uv;
    // Seen along the normal of their plane, or aslant, by an orthographic camera or by one that comes closer to a side of it. In the plane, `w` is any number from 1 on.
    uint pick = ((rays[line].frac.x ^ uint(rays[line].cell.y)) + group) * 0x9e3779b9u;
    float w = float[](1.0, 2.0, 5.0, 40.0)[pick >> 30], closer = float[](0.0, 0.2, -0.2, 0.01)[(pick >> 28) & 3u] * w, aslant = float[](0.0, 0.0, 3.0, -0.3)[(pick >> 26) & 3u];
    // So slowly that few voxels are beside the camera: each of those is a candidate of all pixels, and software drivers end loops after 65,535 rounds.
    float extent = 2.0 + 7.0 * sqrt(max(uu, vv));
    closer = w < 2.0 && extent > 4.0 ? 0.0 : closer / extent;
    // Of the small ones one in four is seen from one to three voxels away: voxels reach to the camera and behind it.
    if (extent < 8.0 && (pick & 0x03000000u) == 0u) closer = (closer < 0.0 ? -w : w) / float[](3.0, 1.25, 1.0, 1.0)[(pick >> 22) & 3u];
    vec3 normal = cross(u, v) / sqrt(area), at_w = normal * closer, right = (u * vv - v * uv) / area, below = (v * uu - u * uv) / area;
    vec4 view[3] = vec4[](vec4(right * w + normal * aslant + at_w * first.x, first.x * w), vec4(below * w - normal * aslant + at_w * first.y, first.y * w), vec4(at_w, w));
    uint wide = (pick >> 18) & 15u;
    most_near = wide == 0u ? 0.0 : 1.0e9;
    most_area = wide == 1u ? 0.0 : 1.0e9;
    begin_tile();
    uint rest = rx_trace_parallel(tile, size, ray.dir, ray.cell, ray.frac, view);
    for (uint s = 0u; s < 8u; ++s) {
        ivec2 pixel = rx_tile_pixel(tile, s);
        bool handed_on = ((rest >> s) & 1u) != 0u, traced = wanted(pixel) && is_of_tile(line_of(pixel));
        // The 32 pixels hand on all pixels, before it is known which have a ray.
        if (handed_on) check_pixel(pixel);
        if (handed_on && (traced || most_near > 0.0)) name_pixel(pixel);
        if (!wanted(pixel) || (!handed_on && traced)) continue;
        RxHit hit;
        bool found = rx_trace(ray_of(line_of(pixel)), hit);
        write_hit(line_of(pixel), found, hit);
    }
    barrier();
    for (uint s = 0u; s < 8u; ++s) {
        ivec2 pixel = rx_tile_pixel(tile, s);
        check_named(pixel, wanted(pixel) && is_of_tile(line_of(pixel)));
    }
    end_tile();
}
#elif defined(RX_MARCH_BEAM)
// A group traces a tile of 8 x 8 pixels. It has five lines, which hold its camera: see rays/words.rs.
#include <raxel/beam.glsl>

const int TILE = 8;
const int COARSE = 16;
const int ROUNDS = 16;

shared float free_depth;

void main() {
    uint tile = gl_WorkGroupID.x * 5u;
    ivec3 cell = rays[tile].cell;
    vec3 frac = uintBitsToFloat(rays[tile].frac);
    mat4 view_to_world = mat4(uintBitsToFloat(rays[tile + 1u].dir), uintBitsToFloat(rays[tile + 2u].dir),
                              uintBitsToFloat(rays[tile + 3u].dir), vec4(0.0, 0.0, 0.0, 1.0));
    vec2 tan_half_fov = uintBitsToFloat(rays[tile + 4u].frac.xy);
    ivec2 size = rays[tile + 4u].cell.xy;
    ivec2 first = ivec2(rays[tile + 4u].dir.xy);
    if (gl_LocalInvocationIndex == 0u) {
        // As graphs/bench/beam.toml does it: a beam for the tile around, and one that goes on from there.
        ivec2 around = first / COARSE * COARSE;
        float depth = rx_beam(cell, frac, view_to_world, tan_half_fov, around, min(around + COARSE, size) - 1, size, 0.0, ROUNDS);
        if (depth < RX_BEAM_NOTHING) {
            depth = rx_beam(cell, frac, view_to_world, tan_half_fov, first, first + TILE - 1, size, depth, ROUNDS);
        }
        free_depth = depth;
    }
    barrier();
    uint i = gl_GlobalInvocationID.x;
    ivec2 pixel = first + ivec2(gl_LocalInvocationIndex % uint(TILE), gl_LocalInvocationIndex / uint(TILE));
    RxRay ray = rx_camera_ray(cell, frac, view_to_world, tan_half_fov, pixel, size);
    RxHit hit = RxHit(ivec3(0), 0u, 0u, 0.0, vec2(0.0), 0u);
    bool found = free_depth < RX_BEAM_NOTHING
        && rx_trace_from(ray, rx_beam_time(free_depth, view_to_world, tan_half_fov, pixel, size), hit);
    if (i < count) write_hit(i, found, hit);
}
#elif defined(RX_MARCH_INSTANCES) || defined(RX_MARCH_INSTANCES_ONWARD)
#include <raxel/instances.glsl>

void write_scene_hit(uint i, bool found, RxSceneHit hit) {
    uvec3 cell = uvec3(hit.cell) & 1023u;
    uint instance = (hit.instance & 0xffffu) | (hit.cell_face << 16) | (hit.free ? 1u << 24 : 0u);
    hits[i] = HitWords(hit.at.voxel, found ? RX_HIT : RX_MISS, hit.at.face, hit.at.material, cell.x | (cell.y << 10) | (cell.z << 20),
                       floatBitsToUint(hit.at.t), floatBitsToUint(hit.at.uv), hit.at.steps, instance);
}

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= count) return;
    RxSceneHit hit;
#ifdef RX_MARCH_INSTANCES_ONWARD
    RxSceneHit from = RxSceneHit(hit_before(i), rays[i].t_free, (rays[i].t_max & 0x100u) != 0u, ivec3(0), 0u);
    bool found = rx_trace_scene(rx_scene_ray_from_hit(from, direction_onward(i)), hit);
    // No hit's place is judged here: its words are for the normal.
    hit.at.uv = rx_scene_normal(from).xy;
#else
    RxRay ray = rx_ray(rays[i].cell, uintBitsToFloat(rays[i].frac), uintBitsToFloat(rays[i].dir.xyz));
    ray.t_max = uintBitsToFloat(rays[i].t_max);
    bool found = rx_trace_scene(rx_scene_ray(ray), hit);
#endif
    write_scene_hit(i, found, hit);
#ifndef RX_MARCH_INSTANCES_ONWARD
    // A ray that ends a little before its hit hits nothing behind its end.
    RxSceneHit before;
    ray.t_max = hit.at.t * 0.99998;
    if (found && rx_trace_scene(rx_scene_ray(ray), before) && before.at.t > ray.t_max) hits[i].state = RX_WRONG;
#endif
}
#elif defined(RX_MARCH_ONWARD)
#include <raxel/box.glsl>

// Whether the test finds that a ray meets the voxel that it hits, and with a margin of two also a voxel two away from it. The cell past a
// box is in the range of coordinates.
bool meets(RxRay ray, ivec3 voxel) {
    ivec3 beside = voxel + mix(ivec3(2), ivec3(-2), greaterThanEqual(voxel, ivec3(0)));
    return rx_crosses_box(ray, beside, beside + 1, 2) && (any(equal(voxel, ivec3(0x7fffffff))) || rx_crosses_box(ray, voxel, voxel + 1, 0));
}

// Whether the test finds that a ray meets none of the boxes that it moves away from or stays beside. They are within the range of
// coordinates.
bool passes(RxRay ray) {
    if (any(greaterThan(abs(ray.cell), ivec3(0x7fffff00)))) return true;
    vec3 dir = rx_lattice_direction(ray);
    for (int a = 0; a < 3; ++a) {
        ivec3 low = ray.cell - 64, end = ray.cell + 64;
        bool down = dir[a] < 0.0;
        float behind = down ? 1.0 - ray.frac[a] : ray.frac[a];
        // Along an axis that the ray does not move along, the second cell beside its own; else the cell behind it.
        low[a] = ray.cell[a] + (dir[a] == 0.0 ? 2 : down ? 1 : -1);
        end[a] = low[a] + 1;
        if ((dir[a] == 0.0 || (abs(dir[a]) >= 1.0 && behind > 0.125)) && rx_crosses_box(ray, low, end, 0)) return false;
    }
    return true;
}

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= count) return;
    RxHit before = hit_before(i);
    RxRay ray = rx_ray_from_hit(before, direction_onward(i));
    RxHit hit;
    bool found = rx_trace(ray, hit);
    // The hit's cache must not change the answers for other voxels.
    bool knows_others = true;
    for (uint k = 0u; k < 4u; ++k) {
        uint other = (i + k * k * 17u) % count;
        knows_others = knows_others && rx_material(rays[other].cell) == rays[other].dir.w;
    }
    if (!knows_others) hits[i].state = RX_WRONG;
    else if (!passes(ray)) hits[i].state = RX_WRONG;
    else write_hit(i, found && meets(ray, hit.voxel), hit);
}
#elif defined(RX_MARCH_STORE)
void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= count) return;
    bool stored = rx_set(rays[i].cell, rays[i].t_max);
    hits[i] = HitWords(rays[i].cell, stored ? RX_HIT : RX_MISS, 0u, 0u, 0u, 0u, uvec2(0u), 0u, 0u);
}
#elif defined(RX_MARCH_PERIOD) || defined(RX_MARCH_REFILL)
// The lines are period rays: see rays/words.rs.
#ifdef RX_MARCH_REFILL
#define RX_ITEMS 96u
#include <raxel/refill.glsl>
#else
#include <raxel/period.glsl>
#endif

RxPeriodRay ray_of(uint i) {
    return RxPeriodRay(rays[i].cell, rays[i].t_max, uintBitsToFloat(rays[i].frac), uintBitsToFloat(rays[i].dir.xyz));
}

// Whether rx_period_ray makes a ray along a period ray by the rule: nothing of one without a direction, and the same periods, but as long
// as those of a unit vector. Roots and reciprocals are off by a few units in the last place.
bool is_made_by_rule(uint i, RxPeriodRay ray) {
    bvec3 still = greaterThanEqual(min(ray.first, ray.period), vec3(RX_PERIOD_END)), down = notEqual(uvec3(ray.octant) & uvec3(1u, 2u, 4u), uvec3(0u));
    vec3 dir = mix(RX_PERIOD_UNIT / ray.period, vec3(0.0), still), ahead = ray.first / ray.period;
    RxPeriodRay made = rx_period_ray(rx_ray(ray.cell, mix(1.0 - ahead, ahead, down), mix(dir, -dir, down)));
    vec3 period = mix(clamp(ray.period * length(dir), RX_PERIOD_UNIT, RX_PERIOD_END), vec3(RX_PERIOD_END), still);
    vec3 first = mix(clamp(ahead * period, vec3(1.0), period), vec3(RX_PERIOD_END), still);
    vec3 off = 4.0 + period * 4.0e-6;
    uvec3 octant = mix(uvec3(ray.octant) & uvec3(1u, 2u, 4u), uvec3(0u), still);
    float bad = uintBitsToFloat(uint[](0u, 0x7f800000u, 0x7f800001u, 0xff800000u)[i & 3u]);
    bool has_none = rx_period_ray(rx_ray(ray.cell, vec3(0.5), vec3(bad, 0.0, 0.0))).period == vec3(0.0);
    return has_none && made.cell == ray.cell && made.octant == (octant.x | octant.y | octant.z)
        && all(lessThanEqual(abs(made.period - period), off)) && all(lessThanEqual(abs(made.first - first), off));
}

void write_period_hit(uint i, bool found, RxPeriodHit hit) {
    uint material = found ? rx_material(hit.voxel) : 0u;
    write_hit(i, found, RxHit(hit.voxel, hit.face, material, hit.t, hit.uv, 0u));
    RxPeriodRay ray = ray_of(i);
    if (ray.period.x > 0.0 && !is_made_by_rule(i, ray)) hits[i].state = RX_WRONG;
}

#ifdef RX_MARCH_REFILL
// One workgroup of four traces the rays of all four, so that lanes whose rays have ended take new ones.
const uint GROUPS = 4u;

shared uint taken;

bool rx_next_items(out uint first) {
    first = RX_ITEMS * atomicAdd(taken, 1u);
    return first < GROUPS * gl_WorkGroupSize.x;
}

uint ray_of_item(uint item) {
    return gl_WorkGroupID.x * gl_WorkGroupSize.x + item;
}

bool rx_next_ray(uint item, out RxPeriodRay ray) {
    if (item >= GROUPS * gl_WorkGroupSize.x || ray_of_item(item) >= count) return false;
    ray = ray_of(ray_of_item(item));
    return true;
}

void rx_ray_traced(uint item, bool found, RxPeriodHit hit) {
    write_period_hit(ray_of_item(item), found, hit);
}

void main() {
    if (gl_WorkGroupID.x % GROUPS != 0u) return;
    if (gl_LocalInvocationIndex == 0u) taken = 0u;
    barrier();
    rx_trace_items();
}
#else
void main() {
    rx_period_prepare(gl_LocalInvocationIndex, gl_WorkGroupSize.x);
    uint i = gl_GlobalInvocationID.x;
    if (i >= count) return;
    RxPeriodHit hit;
    bool found = rx_trace_period(ray_of(i), hit);
    write_period_hit(i, found, hit);
}
#endif
#else
#ifdef RX_MARCH_AHEAD
#include <raxel/box.glsl>
#endif

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= count) return;
    RxRay ray = rx_ray(rays[i].cell, uintBitsToFloat(rays[i].frac), uintBitsToFloat(rays[i].dir.xyz));
    ray.t_max = uintBitsToFloat(rays[i].t_max);
    RxHit hit;
#ifdef RX_MARCH_AHEAD
    bool found = rx_trace_from(ray, uintBitsToFloat(rays[i].t_free), hit);
    write_hit(i, found, hit);
    // The test for boxes must find that a ray meets the voxel that it hits, from however far away. The cell past a box is in the range of coordinates.
    if (found && all(lessThan(hit.voxel, ivec3(0x7fffffff))) && !rx_crosses_box(ray, hit.voxel, hit.voxel + 1, 0)) hits[i].state = RX_WRONG;
#else
    bool found = rx_march(ray, hit);
    write_hit(i, found, hit);
#endif
}
#endif
