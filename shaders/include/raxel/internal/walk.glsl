// The exact walk of a lattice ray through a cube of 2^k voxels a side: steps over empty blocks, never over a solid voxel.
//
// The walk mirrors all axes of negative direction, so that the ray never moves down: cell c of the cube is q = c, or 2^k - 1 - c on a mirrored
// axis. Along each axis the ray crosses planes n = 1, 2, 3, ... after its origin, at
//     t(n) = (n * 2^24 - G) / D        (units: lattice steps)
// with G in [0, 2^24] the mirrored fraction and D in [0, 2^31) the size of the direction, both integers. A comparison of integer products
// decides which of two crossings comes first. Floating point proposes; when it cannot decide (its error is bounded by RX_WALK_ERROR, a few times
// the sum of Vulkan's guaranteed roundings), integers do. See docs/exactness.md.
//
// Ties: a ray that crosses several planes at once steps over all of them at once; the cells it only touches are not visited.
#ifndef RAXEL_WALK_GLSL
#define RAXEL_WALK_GLSL

#include "../ray.glsl"

const float RX_WALK_ERROR = 9.5367431640625e-7;  // 2^-20, relative to the cells passed, plus one
const float RX_NEVER = 1.0e38;                   // crossing time on an axis the ray does not move along

// 1.5 * 2^23: the sum of this and a small float is rounded to an integer, which is in its low bits.
const float RX_ROUND = 12582912.0;

struct RxWalk {
    uvec3 q;      // current cell
    uint axes;    // bit a: the last step crossed a plane of axis a; 0 in the origin's own cell
    uint down;    // bit a: axis a is mirrored
    vec3 d;       // D * 2^-30, exactly
    vec3 inv;     // 1 / d, or 0

    // The frame: the cell and the time that the floating-point walk counts from. No cell behind it is visited any more.
    uvec3 entry;  // the origin's cell, or one further on
    vec3 start;   // place in that cell, 0 to 1, less one half
    vec3 first;   // time from the frame to the first plane; RX_NEVER on an axis that the ray does not move along
    float base;   // time of the frame since the origin, about
    float t;      // time of the last step since the frame, in units of d
    float t_end;  // time since the frame after which no hit can be within ray.t_max
};

// The integers of the ray. Rarely needed, so they are worked out again rather than kept.
struct RxExact {
    uvec3 origin;  // the ray's own cell, modulo 2^32: crossings since the origin are q - origin
    uvec3 g, d;    // G and D
};

// The flip that turns a mirrored cell around: c = q ^ flip. `last` is the largest coordinate in the cube.
uvec3 rx_walk_flip(RxWalk w, uint last) {
    return uvec3((w.down & 1u) != 0u ? last : 0u, (w.down & 2u) != 0u ? last : 0u, (w.down & 4u) != 0u ? last : 0u);
}

bvec3 rx_walk_down(RxWalk w) {
    return bvec3((w.down & 1u) != 0u, (w.down & 2u) != 0u, (w.down & 4u) != 0u);
}

RxExact rx_walk_exact(RxWalk w, RxRay ray, ivec3 corner, uint last) {
    RxExact e;
    e.d = uvec3(w.d * 1073741824.0);
    bvec3 down = rx_walk_down(w);
    uvec3 fixed_frac = uvec3(clamp(ray.frac, 0.0, 1.0) * 16777216.0);
    // At the centre of the cell on an axis that the ray does not move along, where rx_walk_step is sure of it.
    e.g = mix(mix(fixed_frac, uvec3(16777216u) - fixed_frac, down), uvec3(8388608u), equal(e.d, uvec3(0u)));
    uvec3 relative = uvec3(ray.cell) - uvec3(corner);
    e.origin = mix(relative, uvec3(last) - relative, down);
    return e;
}

// Bit a: axis a is in the set.
uint rx_set_of(bvec3 axes) {
    return (axes.x ? 1u : 0u) | (axes.y ? 2u : 0u) | (axes.z ? 4u : 0u);
}

// Components are selected by `mix`. From `?:` glslang makes branches, and a driver takes longer to compile these.
uint rx_pick(uvec3 v, uint axis) {
    return mix(mix(v.z, v.y, axis == 1u), v.x, axis == 0u);
}

void rx_put(inout uvec3 v, uint axis, uint value) {
    v = mix(v, uvec3(value), equal(uvec3(axis), uvec3(0u, 1u, 2u)));
}

void rx_put(inout vec3 v, uint axis, float value) {
    v = mix(v, vec3(value), equal(uvec3(axis), uvec3(0u, 1u, 2u)));
}

// 64-bit integers as (low, high), two's complement.
uvec2 rx_product(uint a, uint b) {
    uvec2 r;
    umulExtended(a, b, r.y, r.x);
    return r;
}

uvec2 rx_difference(uvec2 a, uvec2 b) {
    return uvec2(a.x - b.x, a.y - b.y - (a.x < b.x ? 1u : 0u));
}

// How far plane n_b of axis b is ahead when the ray crosses plane n_a of axis a, times D_a: whole part (floor, 64 bits) and rest
// to be subtracted (24 bits):  ahead = whole - rest * 2^-24.
void rx_walk_ahead(RxExact e, uint a, uint n_a, uint b, uint n_b, out uvec2 whole, out uint rest) {
    uint d_a = rx_pick(e.d, a), d_b = rx_pick(e.d, b);
    uvec2 planes = rx_difference(rx_product(n_b, d_a), rx_product(n_a, d_b));
    uvec2 start = rx_difference(rx_product(rx_pick(e.g, b), d_a), rx_product(rx_pick(e.g, a), d_b));
    rest = start.x & 0xffffffu;
    whole = rx_difference(planes, uvec2((start.x >> 24) | (start.y << 8), uint(int(start.y) >> 24)));
}

// The next plane of axis b, one voxel further ahead: D_a in these units.
void rx_walk_further(RxExact e, uint a, inout uvec2 whole) {
    uint low = whole.x;
    whole.x += rx_pick(e.d, a);
    whole.y += whole.x < low ? 1u : 0u;
}

// Sign of t_b(n_b + next) - t_a(n_a + next_a), where `next` and `next_a` are 0 or 1: -1, 0 or 1. A plane n + 1 may have the number 2^32, which
// fits no word: the plane behind the last cell of all, for an origin in the first.
int rx_walk_compare(RxExact e, uint a, uint n_a, uint next_a, uint b, uint n_b, uint next) {
    uvec2 whole;
    uint rest;
    rx_walk_ahead(e, a, n_a, b, n_b, whole, rest);
    whole = rx_difference(whole, rx_difference(uvec2(next_a * rx_pick(e.d, b), 0u), uvec2(next * rx_pick(e.d, a), 0u)));
    if ((whole.x | whole.y) == 0u) return rest == 0u ? 0 : -1;
    return int(whole.y) < 0 ? -1 : 1;
}

// The same distance in voxels, as a float of full relative precision: `ahead` planes in front lie at 0 to 1.
float rx_walk_gap(RxExact e, uint a, uvec2 whole, uint rest) {
    bool behind = int(whole.y) < 0;
    uint size = mix(whole.x, 0u - whole.x, behind);  // |whole| <= 2^31 here
    precise float gap = float(size) + (behind ? 1.0 : -1.0) * (float(rest) * 5.9604644775390625e-8);
    return clamp(mix(gap, -gap, behind) / float(rx_pick(e.d, a)), -1.0, 1.0);
}

// Of the axes in `axes` (bit a: axis a; at least one), the one whose plane in `planes`, or the `next` = 1 behind that, the ray crosses first, or
// with `sign` = -1 last. Of several at once the first in the order x, y, z.
//
// The comparisons stand in loops over the bits of a set: every call is inlined, and drivers unroll loops of a fixed length.
uint rx_walk_first(RxExact e, uint axes, uvec3 planes, uint next, int sign) {
    uint a = uint(findLSB(axes));
    for (uint others = axes & (axes - 1u); others != 0u; others &= others - 1u) {
        uint b = uint(findLSB(others));
        if (rx_walk_compare(e, a, rx_pick(planes, a), next, b, rx_pick(planes, b), next) * sign < 0) a = b;
    }
    return a;
}

// Number of planes of axis b crossed up to and including the time t_a(n_a), known to lie in [low, high].
uint rx_walk_count(RxExact e, uint a, uint n_a, uint b, uint low, uint high) {
    for (uint i = 0u; i < 32u && low < high; ++i) {
        uint middle = high - ((high - low) >> 1);
        if (rx_walk_compare(e, a, n_a, 0u, b, middle, 0u) <= 0) low = middle;
        else high = middle - 1u;
    }
    return low;
}

// One component of a direction on the lattice; `top` is the exponent of the largest component.
uint rx_lattice_component(uint bits, uint top) {
    uint exponent = (bits >> 23) & 0xffu;
    uint shift = top - exponent;
    return exponent == 0u || shift > 30u ? 0u : (((bits & 0x7fffffu) | 0x800000u) << 7) >> shift;
}

uint rx_lattice_top(vec3 dir) {
    uvec3 exponents = (floatBitsToUint(dir) >> 23) & 0xffu;
    return max(exponents.x, max(exponents.y, exponents.z));
}

bool rx_not_finite(vec3 v) {
    return any(equal(floatBitsToUint(v) & 0x7f800000u, uvec3(0x7f800000u)));
}

// Begins a new frame in the current cell, `since` after the origin. `g` is the place in the cell. `h` is 1 - g, passed apart to keep its own
// precision.
void rx_walk_frame(inout RxWalk w, vec3 g, vec3 h, float since) {
    w.entry = w.q;
    w.start = g - 0.5;
    w.first = mix(h * w.inv, vec3(RX_NEVER), equal(w.inv, vec3(0.0)));
    w.t_end -= since - w.base;
    w.base = since;
    w.t = 0.0;
}

// Goes to the time quarters / 4 after the origin, when every coordinate is a sum of integers.
void rx_walk_skip(inout RxWalk w, RxExact e, uint quarters) {
    uvec3 cells, rest;
    umulExtended(e.d, uvec3(quarters), cells, rest);
    uvec3 start = e.g << 8;  // 2^24 wraps to 0, and is a whole cell
    rest += start;
    w.q = e.origin + cells + mix(uvec3(0u), uvec3(1u), lessThan(rest, start)) + (e.g >> 24);
    w.axes = 8u;  // not in the origin's own cell
    vec3 g = vec3(rest) * 2.3283064365386962890625e-10;
    vec3 h = mix(vec3(uvec3(0u) - rest) * 2.3283064365386962890625e-10, vec3(1.0), equal(rest, uvec3(0u)));
    rx_walk_frame(w, g, h, float(quarters) * 0.25);
}

// Goes to the time when plane n_a of axis a is crossed, by integers alone, and begins a new frame there. By then at least `low`, at
// most `high` planes of the other axes have been crossed.
void rx_walk_cross(inout RxWalk w, RxExact e, uint a, uint n_a, uvec3 low, uvec3 high) {
    precise float t = (float(n_a) - float(rx_pick(e.g, a)) * 5.9604644775390625e-8) / w.d[a];
    w.axes = 1u << a;
    uvec3 counts = uvec3(0u);
    rx_put(counts, a, n_a);
    vec3 g = vec3(e.g) * 5.9604644775390625e-8;
    vec3 h = vec3(uvec3(16777216u) - e.g) * 5.9604644775390625e-8;
    rx_put(g, a, 0.0);
    rx_put(h, a, 1.0);
    for (uint others = 7u & ~(1u << a); others != 0u; others &= others - 1u) {
        uint b = uint(findLSB(others));
        uint count = rx_pick(low, b);
        if (rx_pick(e.d, b) != 0u) {
            uint least = count, most = rx_pick(high, b);
            float x = t * w.d[b] + g[b];
            float error = (x + 1.0) * (4.0 * RX_WALK_ERROR);
            if (x - error > float(least)) least = max(least, uint(min(x - error, 4.29496704e9)));
            if (x + error < float(most)) most = min(most, uint(max(x + error, 0.0)));
            count = rx_walk_count(e, a, n_a, b, min(least, most), most);
            // Behind plane 2^32 is no cell: it ends in the same word as the origin, which is outside of the cube then.
            if (count == 0xffffffffu && rx_walk_compare(e, a, n_a, 0u, b, count, 1u) <= 0) count = 0u;
            uvec2 whole;
            uint rest;
            rx_walk_ahead(e, a, n_a, b, count, whole, rest);
            if (count != 0u && (whole.x | whole.y | rest) == 0u) w.axes |= 1u << b;
            rx_put(g, b, -rx_walk_gap(e, a, whole, rest));
            rx_walk_further(e, a, whole);
            rx_put(h, b, rx_walk_gap(e, a, whole, rest));
        }
        rx_put(counts, b, count);
    }
    w.q = e.origin + counts;
    rx_walk_frame(w, g, h, t);
}

// Enters the cube: the ray's cell and time when it first is in it. False if it never is.
bool rx_walk_enter(inout RxWalk w, RxExact e, bvec3 before, uint last) {
    // The last of the three slabs to be entered.
    uvec3 enter = uvec3(0u) - e.origin;
    uint a = rx_walk_first(e, rx_set_of(before), enter, 0u, -1);
    uint n_a = rx_pick(enter, a);
    // Another slab may be left before.
    uvec3 in_last = uvec3(last) - e.origin;
    for (uint others = rx_set_of(notEqual(e.d, uvec3(0u))) & ~(1u << a); others != 0u; others &= others - 1u) {
        uint b = uint(findLSB(others));
        if (rx_walk_compare(e, a, n_a, 0u, b, rx_pick(in_last, b), 1u) <= 0) return false;
    }
    rx_walk_cross(w, e, a, n_a, mix(uvec3(0u), enter, before), in_last);
    return true;
}

// Time in units of d of a time in lengths of a direction.
float rx_walk_scale(vec3 dir) {
    return uintBitsToFloat(clamp(rx_lattice_top(dir), 1u, 254u) << 23);
}

// Time in lengths of a direction of one in units of d.
float rx_walk_lengths(vec3 dir, float t) {
    uint top = rx_lattice_top(dir);
    precise float lengths = t * uintBitsToFloat(max(254u - top, 1u) << 23);
    // 2^-127 is below the normal floats, and so are two factors.
    precise float half_of = lengths * 0.5;
    return top > 253u ? half_of : lengths;
}

// The direction on the lattice. False if the ray is invalid.
bool rx_walk_lattice(RxRay ray, out RxWalk w, out bvec3 still, out bvec3 down) {
    uint top = rx_lattice_top(ray.dir);
    uvec3 bits = floatBitsToUint(ray.dir);
    uvec3 d_fixed = uvec3(rx_lattice_component(bits.x, top), rx_lattice_component(bits.y, top), rx_lattice_component(bits.z, top));
    still = equal(d_fixed, uvec3(0u));
    down = bvec3((bits.x >> 31) != 0u && !still.x, (bits.y >> 31) != 0u && !still.y, (bits.z >> 31) != 0u && !still.z);
    w.down = rx_set_of(down);
    w.d = vec3(d_fixed) * 9.31322574615478515625e-10;
    w.inv = mix(1.0 / max(w.d, vec3(1.0e-20)), vec3(0.0), still);
    return top != 0u && !rx_not_finite(ray.dir) && !rx_not_finite(ray.frac);
}

// Puts a ray on the lattice and enters the cube of 2^log2_size voxels (at most 2^30) whose smallest corner is `corner`.
// False if the ray is invalid or never is in the cube. `t_free`, in lengths of the direction, is the caller's promise: the ray passes only air
// until then. The walk skips these cells.
bool rx_walk_begin(RxRay ray, ivec3 corner, uint log2_size, float t_free, out RxWalk w) {
    uint last = (1u << log2_size) - 1u;
    bvec3 still, down;
    bool valid = rx_walk_lattice(ray, w, still, down);
    RxExact e = rx_walk_exact(w, ray, corner, last);
    w.base = 0.0;
    float scale = rx_walk_scale(ray.dir);
    w.t_end = ray.t_max >= 1.0e37 ? RX_FAR : ray.t_max * scale * 1.0001 + 1.0e-3;

    bvec3 below = lessThan(ray.cell, corner);
    bvec3 above = greaterThan(ray.cell, corner + ivec3(last));
    bvec3 before = mix(below, above, down);
    bvec3 past = mix(above, below, down);
    bvec3 lost = bvec3(past.x || (still.x && before.x), past.y || (still.y && before.y), past.z || (still.z && before.z));
    if (!valid || any(lost)) return false;

    float skip = t_free * scale * 0.999998 - 0.25;
    if (skip > 0.25 && skip < 1.0e9) {
        rx_walk_skip(w, e, uint(skip * 4.0));
        // If the ray began before the cube on an axis, its coordinate wraps past 2^32. If it does not, it is at the other end of the coordinates.
        if (((w.q.x | w.q.y | w.q.z) >> log2_size) == 0u && lessThan(w.q, e.origin) == before) return true;
        // Not in the cube at that time: the ray enters it later, if at all.
    }
    w.axes = 0u;
    w.q = e.origin;
    rx_walk_frame(w, vec3(e.g) * 5.9604644775390625e-8, vec3(uvec3(16777216u) - e.g) * 5.9604644775390625e-8, 0.0);
    return any(before) ? rx_walk_enter(w, e, before, last) : true;
}

// Goes to the time `t` since the frame, which is one of `times`. On that axis, the ray enters cell `to`. If floating point cannot decide the
// cell on the other two axes, returns false and does nothing.
//
// The place on each axis less one half is rounded to the nearest integer, which is the cell, unless it is nearly between two.
bool rx_walk_to(inout RxWalk w, vec3 times, float t, uvec3 to) {
    bool x = times.x == t, y = !x && times.y == t, z = !x && !y;
    vec3 place = fma(vec3(t), w.d, w.start);
    precise vec3 rounded = place + RX_ROUND;
    precise vec3 cell = rounded - RX_ROUND;
    precise vec3 off = abs(place - cell);
    vec3 most = (0.5 - 1.5 * RX_WALK_ERROR) - RX_WALK_ERROR * place;
    bvec3 crossed = bvec3(x, y, z);
    if (any(mix(greaterThan(off, most), bvec3(false), crossed))) return false;
    uvec3 there = w.entry + (floatBitsToUint(rounded) - floatBitsToUint(RX_ROUND));
    w.q = mix(there, to, crossed);
    w.axes = mix(mix(4u, 2u, y), 1u, x);
    w.t = t;
    return true;
}

// Leaves the aligned block that holds the current cell; `block` is the largest coordinate within it, one less than a power of two for each
// axis. If floating point cannot decide the next cell, returns false and does nothing: then call rx_walk_settle. It is a function apart, so that
// tracers can keep it out of their inner loop. It is rarely needed, but a group of threads takes as long as its slowest, and some drivers run
// both sides of an `if`.
bool rx_walk_step(inout RxWalk w, uvec3 block) {
    uvec3 last = w.q | block;
    // Whether the device fuses it or not makes no difference to the bound; fused it is one instruction.
    vec3 times = fma(vec3(last - w.entry), w.inv, w.first);
    return rx_walk_to(w, times, min(times.x, min(times.y, times.z)), last + 1u);
}

// The same of a cube of 2^shift voxels a side.
bool rx_walk_step(inout RxWalk w, uint shift) {
    return rx_walk_step(w, uvec3((1u << shift) - 1u));
}

// The same step by integers.
void rx_walk_settle(inout RxWalk w, RxRay ray, ivec3 corner, uint log2_size, uvec3 block) {
    RxExact e = rx_walk_exact(w, ray, corner, (1u << log2_size) - 1u);
    uvec3 here = w.q - e.origin;
    uvec3 in_last = (w.q | block) - e.origin;
    uint a = rx_walk_first(e, rx_set_of(notEqual(e.d, uvec3(0u))), in_last, 1u, 1);
    rx_walk_cross(w, e, a, rx_pick(in_last, a) + 1u, here, max(in_last, in_last + 1u));
}

void rx_walk_settle(inout RxWalk w, RxRay ray, ivec3 corner, uint log2_size, uint shift) {
    rx_walk_settle(w, ray, corner, log2_size, uvec3((1u << shift) - 1u));
}

// The last cell on each axis before the ray has left the bounds of all solids (`low` to `high`, in the world's cube) for good.
uvec3 rx_walk_limit(RxWalk w, uint log2_size, ivec3 low, ivec3 high) {
    uvec3 last = uvec3((1u << log2_size) - 1u);
    return min(mix(uvec3(high), last - uvec3(low), rx_walk_down(w)), last);
}

// Fills in all of a hit but its material: the current cell is the voxel. False if it lies beyond ray.t_max.
bool rx_walk_hit(RxWalk w, RxRay ray, ivec3 corner, uint log2_size, out RxHit hit) {
    uint last = (1u << log2_size) - 1u;
    hit.voxel = corner + ivec3(w.q ^ rx_walk_flip(w, last));
    hit.material = 0u;
    hit.steps = 0u;
    if (w.axes == 0u) {
        hit.face = RX_FACE_INSIDE;
        hit.t = 0.0;
        hit.uv = clamp(ray.frac.xy, 0.0, 1.0);
        return !(ray.t_max < 0.0);
    }
    // On an edge or corner the face of the steepest axis counts, then the one first in the order x, y, z.
    uint a = 0u;
    float steepest = 0.0;
    for (uint i = 0u; i < 3u; ++i) {
        if ((w.axes & (1u << i)) != 0u && w.d[i] > steepest) {
            a = i;
            steepest = w.d[i];
        }
    }
    hit.face = 2u * a + ((w.down >> a) & 1u);

    RxExact e = rx_walk_exact(w, ray, corner, last);
    uvec3 n = w.q - e.origin;
    uint n_a = rx_pick(n, a);
    precise float lattice_t = (float(n_a) - float(rx_pick(e.g, a)) * 5.9604644775390625e-8) / steepest;
    float t = rx_walk_lengths(ray.dir, lattice_t);
    hit.t = t;

    vec3 place = clamp(ray.frac, 0.0, 1.0);
    for (uint others = 7u & ~(1u << a); others != 0u; others &= others - 1u) {
        uint b = uint(findLSB(others));
        if (rx_pick(e.d, b) == 0u) continue;
        // From the plane behind, or in a mirrored axis from the one in front.
        bool mirrored = ((w.down >> b) & 1u) != 0u;
        uvec2 whole;
        uint rest;
        rx_walk_ahead(e, a, n_a, b, rx_pick(n, b), whole, rest);
        if (mirrored) rx_walk_further(e, a, whole);
        rx_put(place, b, abs(rx_walk_gap(e, a, whole, rest)));
    }
    hit.uv = mix(mix(place.xy, place.xz, bvec2(a == 1u)), place.yz, bvec2(a == 0u));
    return ray.t_max >= RX_FAR || t <= ray.t_max;
}

// The same for a ray that is known to hit this voxel on this face, without a walk.
void rx_walk_known_hit(RxRay ray, ivec3 corner, uint log2_size, ivec3 voxel, uint face, out RxHit hit) {
    RxWalk w;
    bvec3 still, down;
    rx_walk_lattice(ray, w, still, down);
    w.q = (uvec3(voxel) - uvec3(corner)) ^ rx_walk_flip(w, (1u << log2_size) - 1u);
    w.axes = face == RX_FACE_INSIDE ? 0u : 1u << rx_face_axis(face);
    rx_walk_hit(w, ray, corner, log2_size, hit);
}
#endif
