// Period rays: rays for light, exact at a quarter of the cost. Over the layout `flat64`.
//
// A period ray crosses the planes of each axis at a fixed period: plane n of axis a, counted from its cell, at the time
//
//     first[a] + n * period[a],      in 1/4096 of the length of a voxel's edge, as long as that is below 2^24
//
// and both are whole numbers. A 32-bit float holds them exactly, so every comparison of two crossings is right: nothing is in doubt,
// and no slow path settles it. A ray ends after 2^24 / 4096 = 4096 voxels of length. The price is the direction: periods round to whole numbers,
// which changes a component of a unit vector by at most 2^-13 of itself. A component below 1/8192 crosses no plane, one up to 1/4096 is 1/4096.
// If that shows as a pattern, dither the direction.
//
// The rules are those of <raxel/ray.glsl>: the ray starts in the closed cube of its cell; it crosses planes of several axes at
// once in one step, without a visit to the cells that it only touches; the face is that of the steepest of these axes, then the
// first.
#ifndef RAXEL_PERIOD_GLSL
#define RAXEL_PERIOD_GLSL

#include "world.glsl"

// A ray that crosses the planes of each axis at whole times, a period apart.
struct RxPeriodRay {
    ivec3 cell;    // voxel that it starts in
    uint octant;   // bit a: it goes down along axis a
    vec3 first;    // when it crosses the first plane of each axis: whole, 1 to period
    vec3 period;   // time between two planes of an axis: whole, 4096 to 2^24. Of one that is 0 the ray hits nothing
};

// The hit of a period ray.
struct RxPeriodHit {
    ivec3 voxel;
    uint face;     // RX_FACE_*
    float t;       // in voxels
    vec2 uv;       // as in RxHit
};

const float RX_PERIOD_UNIT = 4096.0;
const float RX_PERIOD_END = 16777216.0;

// The period ray next to a ray: its direction in whole periods, its origin in whole times. `t_max` is not kept.
RxPeriodRay rx_period_ray(RxRay ray) {
    float size = dot(ray.dir, ray.dir);
    // NaN, infinity and zero hit nothing.
    if (!(size > 0.0 && size < RX_FAR)) return RxPeriodRay(ray.cell, 0u, vec3(0.0), vec3(0.0));
    vec3 dir = ray.dir * inversesqrt(size);
    bvec3 down = lessThan(dir, vec3(0.0));
    vec3 period = clamp(roundEven(RX_PERIOD_UNIT / max(abs(dir), vec3(1.0 / 8192.0))), RX_PERIOD_UNIT, RX_PERIOD_END);
    vec3 ahead = mix(1.0 - ray.frac, ray.frac, down);
    vec3 first = clamp(roundEven(period * ahead), vec3(1.0), period);
    // An axis that the ray hardly moves along is crossed when the ray ends.
    first = mix(first, vec3(RX_PERIOD_END), lessThan(abs(dir), vec3(1.0 / 8192.0)));
    return RxPeriodRay(ray.cell, uint(down.x) | uint(down.y) << 1 | uint(down.z) << 2, first, period);
}

// For each octant and each child of a node: the children that lie ahead of a ray in it, the child itself not counted.
shared uvec2 rx_period_ahead[512];

// Cells are kept as floats whose low bits are the cell: whole numbers from 2^23 up have one bit each. Along an axis that the ray goes
// down, cells are mirrored in the window, so that all rays go up. These are the bits of cell 0, 1.5 * 2^23 + 8192.
const uint RX_PERIOD_CELL = 0x4b402000u;

// The ray that a thread has under way. One variable for all functions: passed as a parameter, its copies take registers, and fewer threads
// run at a time. 1 / period is divided each time for the same reason: kept, it would take three registers.
struct RxPeriodWalk {
    vec3 at;        // the cell
    vec3 start;     // the cell that it started in; plane n takes it to start + 1 + n
    vec3 first;
    vec3 period;
    float t;        // when it came into the cell
    float leaves;   // when it leaves the box of the solids, or ends
    uint octant;    // times 64
    uint mirror;    // mirrors a packed cell
};
RxPeriodWalk rx_period;

// The children that are behind a child on no axis, without the child itself.
uvec2 rx_period_ahead_mask(uint octant, uint child) {
    uint x = child & 3u, z = (child >> 2) & 3u, y = child >> 4;
    uint xs = (octant & 1u) != 0u ? (2u << x) - 1u : (15u << x) & 15u;
    uint zs = (octant & 4u) != 0u ? (16u << (4u * z)) - 1u : (0xffffu << (4u * z)) & 0xffffu;
    uint slice = (xs * 0x1111u) & zs;
    slice |= slice << 16;
    uint ys = (octant & 2u) != 0u ? (2u << y) - 1u : (15u << y) & 15u;
    uvec2 mask = slice & uvec2((ys & 1u) * 0xffffu + ((ys >> 1) & 1u) * 0xffff0000u,
                               ((ys >> 2) & 1u) * 0xffffu + (ys >> 3) * 0xffff0000u);
    if (child < 32u) mask.x &= ~(1u << child); else mask.y &= ~(1u << (child & 31u));
    return mask;
}

// To be called by all threads of a workgroup of `threads` threads before any period ray is traced.
void rx_period_prepare(uint thread, uint threads) {
    for (uint i = thread; i < 512u; i += threads) rx_period_ahead[i] = rx_period_ahead_mask(i >> 6, i & 63u);
    barrier();
}

// A cell of the window as one word: x, z from bit 11, y from bit 22; not mirrored.
uint rx_period_cell() {
    uvec3 low = floatBitsToUint(rx_period.at);
    return (low.x + low.z * 2048u + (low.y * 4194304u - RX_PERIOD_CELL * 2049u)) ^ rx_period.mirror;
}

// The child that holds a packed cell, in a node of 4 or 16 voxels a side. One multiplication brings the three fields of two bits
// together.
uint rx_period_voxel(uint cell) { return ((cell & 0x00c01803u) * 0x00402010u) >> 22; }

// The same for a node of 16 voxels a side.
uint rx_period_leaf(uint cell) { return ((cell & 0x0300600cu) * 0x00100804u) >> 22; }

// Moves the ray to the cell that it is in at a time. The estimate is off by less than half a cell, so the next whole number is the cell or the
// one behind it. The crossing between the two decides exactly.
void rx_period_move(float t) {
    precise vec3 cell = fma(vec3(t) - rx_period.first, 1.0 / rx_period.period, rx_period.start);
    precise vec3 crossed = fma(cell - rx_period.start, rx_period.period, rx_period.first);
    rx_period.t = t;
    rx_period.at = cell + vec3(lessThanEqual(crossed, vec3(t)));
}

// The constants of an octant for the begin and the end of a ray: three quads with a word an axis. They are the number to add to the bits of a
// cell, mirrored where the ray goes down, and the first and last cell of the solids. In front of the records.
uvec4 rx_period_octant(uint octant64, uint part) {
    return world.quads[world.records_at - 24u + (octant64 >> 6) * 3u + part];
}

// False if the ray misses the box of the solids, or ends before.
bool rx_period_begin(RxPeriodRay ray) {
    rx_period.octant = ray.octant << 6;
    rx_period.first = ray.first;
    rx_period.period = ray.period;
    rx_period.t = 0.0;
    uvec4 base = rx_period_octant(rx_period.octant, 0u);
    vec3 near = uintBitsToFloat(rx_period_octant(rx_period.octant, 1u).xyz), far = uintBitsToFloat(rx_period_octant(rx_period.octant, 2u).xyz);
    rx_period.mirror = base.w;
    uvec3 down = uvec3(0u) - (uvec3(ray.octant, ray.octant >> 1, ray.octant >> 2) & 1u);
    uvec3 bits = (uvec3(ray.cell) ^ down) + base.xyz;
    // A voxel further away than the ray is long cannot be met.
    uvec3 off = bits ^ (RX_PERIOD_CELL - 8192u);
    if ((off.x | off.y | off.z) >= 16384u || rx_wraps(ray.cell, world.origin)) return false;
    rx_period.start = uintBitsToFloat(bits);
    rx_period.at = rx_period.start;
    precise vec3 leave = fma(far - rx_period.start, rx_period.period, rx_period.first);
    rx_period.leaves = min(min(leave.x, leave.y), min(leave.z, RX_PERIOD_END));
    precise vec3 enter = fma(near - 1.0 - rx_period.start, rx_period.period, rx_period.first);
    float t = max(max(rx_period.start.x < near.x ? enter.x : 0.0, rx_period.start.y < near.y ? enter.y : 0.0), rx_period.start.z < near.z ? enter.z : 0.0);
    if (t > 0.0) rx_period_move(t);
    return ray.period.x > 0.0 && t < rx_period.leaves;
}

const uint RX_PERIOD_GOES = 0u, RX_PERIOD_HIT = 1u, RX_PERIOD_GONE = 2u;

// Looks at the ray's cell, and leaves the largest free block that holds it.
uint rx_period_round() {
    uint cell = rx_period_cell();
    uvec4 record = world.quads[world.records_at + ((cell >> 4) & 127u) + (world.strides & 0xffffu) * ((cell >> 15) & 127u) +
                               (world.strides >> 16) * (cell >> 26)];
    uint radius = (record.w >> (rx_period.octant >> 4)) & 15u;

    uint child = rx_period_leaf(cell);
    bool high = (child & 32u) != 0u;
    uint half_mask = high ? record.y : record.x;
    uint upto = half_mask << (~child & 31u);  // the child's bit on top
    uvec2 ahead = rx_period_ahead[rx_period.octant + child];
    bool free = ((ahead.x & record.x) | (ahead.y & record.y)) == 0u;
    uint block = ((half_mask >> (child & 10u)) & 0x00330033u) == 0u ? 7u : 3u;
    if (int(upto) < 0) {
        uvec2 leaf = rx_leaf(record.z + uint(bitCount(upto)) + (high ? uint(bitCount(record.x)) : 0u));
        uint voxel = rx_period_voxel(cell);
        uint half_leaf = (voxel & 32u) != 0u ? leaf.y : leaf.x;
        if (((half_leaf >> (voxel & 31u)) & 1u) != 0u) return RX_PERIOD_HIT;
        block = ((half_leaf >> (voxel & 10u)) & 0x00330033u) == 0u ? 1u : 0u;
        uvec2 beyond = rx_period_ahead[rx_period.octant + voxel];
        bool clear = ((beyond.x & leaf.x) | (beyond.y & leaf.y)) == 0u;
        if (clear) block = 3u;
        free = free && clear;
    }
    float more = 0.0;
    if (free) {
        block = 15u;
        more = float(radius << 4);
    }
    precise vec3 edge = uintBitsToFloat(floatBitsToUint(rx_period.at) | block) + more;
    precise vec3 leave = fma(edge - rx_period.start, rx_period.period, rx_period.first);
    rx_period_move(min(min(leave.x, leave.y), leave.z));
    return rx_period.t >= rx_period.leaves ? RX_PERIOD_GONE : RX_PERIOD_GOES;
}

// Of a ray whose cell is solid.
RxPeriodHit rx_period_hit() {
    uint face = RX_FACE_INSIDE;
    if (rx_period.t > 0.0) {
        precise vec3 crossed = fma(rx_period.at - rx_period.start - 1.0, rx_period.period, rx_period.first);
        float steepest = RX_FAR;
        for (uint axis = 0u; axis < 3u; ++axis) {
            if (crossed[axis] == rx_period.t && rx_period.period[axis] < steepest) {
                steepest = rx_period.period[axis];
                face = 2u * axis + ((rx_period.octant >> (6u + axis)) & 1u);
            }
        }
    }
    // How far it is into the cell.
    vec3 place = clamp(fma(vec3(rx_period.t) - rx_period.first, 1.0 / rx_period.period, rx_period.start - rx_period.at + 1.0), 0.0, 1.0);
    place = mix(place, 1.0 - place, notEqual(uvec3(rx_period.octant) & uvec3(64u, 128u, 256u), uvec3(0u)));
    vec2 uv = face < 2u ? place.yz : face < 4u ? place.xz : place.xy;
    uvec3 down = uvec3(0u) - (uvec3(rx_period.octant >> 6, rx_period.octant >> 7, rx_period.octant >> 8) & 1u);
    ivec3 voxel = ivec3((floatBitsToUint(rx_period.at) - rx_period_octant(rx_period.octant, 0u).xyz) ^ down);
    return RxPeriodHit(voxel, face, rx_period.t * (1.0 / RX_PERIOD_UNIT), uv);
}

// The first solid voxel along a period ray.
bool rx_trace_period(RxPeriodRay ray, out RxPeriodHit hit) {
    uint state = rx_period_begin(ray) ? RX_PERIOD_GOES : RX_PERIOD_GONE;
    while (state == RX_PERIOD_GOES) state = rx_period_round();
    hit = RxPeriodHit(ivec3(0), 0u, 0.0, vec2(0.0));
    if (state == RX_PERIOD_HIT) hit = rx_period_hit();
    return state == RX_PERIOD_HIT;
}

#endif
