// The common part of packet.glsl (rays of a camera) and parallel.glsl (rays of one direction): one subgroup of 32 invocations traces a tile of
// 16 x 16 pixels. A shader defines two functions, which get one call for each decided pixel:
//
//     void rx_tile_hit(ivec2 pixel, ivec3 voxel, uint face);
//     void rx_tile_miss(ivec2 pixel);
#ifndef RAXEL_TILE_GLSL
#define RAXEL_TILE_GLSL

// Uses the older ballots and votes, and shared memory in place of shuffles. KHR_shader_subgroup counts active invocations: if a compiler cannot prove
// that all are active, it checks in every round of a loop. Here all are always active: control flow around every ballot, vote and barrier is the
// same in the whole workgroup.
#extension GL_KHR_shader_subgroup_basic : require
#extension GL_ARB_shader_ballot : require
#extension GL_ARB_shader_group_vote : require
#extension GL_ARB_gpu_shader_int64 : require

#include "walk.glsl"

void rx_tile_hit(ivec2 pixel, ivec3 voxel, uint face);
void rx_tile_miss(ivec2 pixel);

#ifdef RX_TILE_BY_SHARED_MEMORY
// The same through shared memory, for any width of a subgroup, by three barriers each: for tests on devices without subgroups of 32 or 64.
shared uint rx_tile_votes;

uint rx_tile_ballot(bool vote) {
    barrier();
    if (gl_LocalInvocationIndex == 0u) rx_tile_votes = 0u;
    barrier();
    if (vote) atomicOr(rx_tile_votes, 1u << gl_LocalInvocationIndex);
    barrier();
    return rx_tile_votes;
}

uint rx_tile_read(uint value, uint lane) {
    barrier();
    if (gl_LocalInvocationIndex == lane) rx_tile_votes = value;
    barrier();
    return rx_tile_votes;
}

#define RX_TILE_BALLOT(vote) rx_tile_ballot(vote)
#define RX_TILE_ANY(vote) (rx_tile_ballot(vote) != 0u)
#define RX_TILE_READ(value, lane) rx_tile_read(value, lane)
#define RX_TILE_IN_STEP true
#else
#define RX_TILE_BALLOT(vote) unpackUint2x32(ballotARB(vote)).x
#define RX_TILE_ANY(vote) anyInvocationARB(vote)
#define RX_TILE_READ(value, lane) readInvocationARB(value, lane)
// The workgroup is one subgroup: there are drivers that name a larger size than they run (lavapipe with LP_NATIVE_VECTOR_WIDTH above 512). Of a subgroup of
// 64 one half is at work, if the workgroup is that half: the upper words of its ballots are empty.
#define RX_TILE_IN_STEP (gl_NumSubgroups == 1u && (gl_SubgroupSize == 32u || (gl_SubgroupSize == 64u && allInvocationsARB(gl_SubgroupInvocationID == gl_LocalInvocationIndex))))
#endif

const int RX_TILE = 16;                          // pixels along an edge of a tile
const float RX_TILE_SLACK = 1.0 / 256.0;         // voxels: more than a place is off by rounding, within RX_TILE_REACH of the camera
const int RX_TILE_REACH = 1 << 13;
const float RX_TILE_ERROR = 9.5367431640625e-7;  // 2^-20, of a direction's length and of a time, see docs/exactness.md
const float RX_TILE_MARGIN = 1.0 / 64.0;         // pixels: more than the projection of a voxel is off, below

// A node: its index, and the height of its children above bit 28; or this, if all of it is full and has no node.
const uint RX_TILE_FULL = 0x80000000u;

// Every index into shared memory ends with a mask. So raxel sees that the index is inside, and compiles no bound for it. No mask
// changes an index.

// A ring of the voxels that the frustum touches, the first at `taken`: x | y << 8 | z << 16 from the corner of their node of 16^3, in mirrored axes.
shared uint rx_tile_candidates[128];
// A word of each invocation, on the way from candidates to their sets.
shared uint rx_tile_words[32];
// The same, and then which candidates each column (from 0 on) and each row (from 16 on) of pixels has.
shared uint rx_tile_lists[32];
// Places of up to 32 candidates, by their bit in a set.
shared vec4 rx_tile_corners[32];
// From places to pixels, in sixteenths.
shared vec4 rx_tile_project[4];

uint rx_tile_rotate(uint x, uint by) {
    return (x << by) | (x >> (32u - by));
}

// A leaf's mask, halves in mirrored order, without voxels that no ray can hit first: those whose seven neighbours towards the origin are solid.
uvec2 rx_tile_bare(uvec2 mask, bool down_x, bool down_y, bool down_z) {
    if (down_y) mask = mask.yx;
    uint step_x = down_x ? 31u : 1u, within_x = down_x ? 0x77777777u : 0xeeeeeeeeu;
    uint step_z = down_z ? 28u : 4u, within_z = down_z ? 0x0fff0fffu : 0xfff0fff0u;
    uint a = mask.x, b = mask.y, second = down_y ? 0x0000ffffu : 0xffff0000u;
    a &= rx_tile_rotate(a, step_x) & within_x;
    b &= rx_tile_rotate(b, step_x) & within_x;
    a &= rx_tile_rotate(a, step_z) & within_z;
    b &= rx_tile_rotate(b, step_z) & within_z;
    uint s = rx_tile_rotate(a, 16u), t = rx_tile_rotate(b, 16u);
    return mask & ~uvec2(a & s & second, b & ((t & second) | (s & ~second)));
}

// Invocation l has the `set` of candidate l: bit i for column i of pixels, bit 16 + i for row i. The result is rx_tile_lists[i] with the candidates of
// column i, and rx_tile_lists[16 + i] with those of row i. Candidate l is bit 31 - l, so the first is the highest. A barrier has to follow.
void rx_tile_sets(uint lane, uint set) {
    // First, each word turns so that bit p + l becomes bit p. Then bit p moves on by p invocations: by the eights in p, by the twos, by one. Last,
    // words turn again.
    set = (set >> lane) | (set << ((32u - lane) & 31u));
    rx_tile_words[lane & 31u] = set;
    barrier();
    set = (set & 0x000000ffu) | (rx_tile_words[(lane - 8u) & 31u] & 0x0000ff00u) |
          (rx_tile_words[(lane ^ 16u) & 31u] & 0x00ff0000u) | (rx_tile_words[(lane + 8u) & 31u] & 0xff000000u);
    rx_tile_lists[lane & 31u] = set;
    barrier();
    set = (set & 0x03030303u) | (rx_tile_lists[(lane - 2u) & 31u] & 0x0c0c0c0cu) |
          (rx_tile_lists[(lane - 4u) & 31u] & 0x30303030u) | (rx_tile_lists[(lane - 6u) & 31u] & 0xc0c0c0c0u);
    rx_tile_words[lane & 31u] = set;
    barrier();
    set = (set & 0x55555555u) | (rx_tile_words[(lane - 1u) & 31u] & 0xaaaaaaaau);
    uint by = (lane + 1u) & 31u;
    rx_tile_lists[lane & 31u] = (set >> by) | (set << ((32u - by) & 31u));
}

// A direction on the lattice, without its signs.
uvec3 rx_tile_lattice(vec3 dir) {
    uvec3 bits = floatBitsToUint(dir);
    uint top = rx_lattice_top(dir);
    return uvec3(rx_lattice_component(bits.x, top), rx_lattice_component(bits.y, top), rx_lattice_component(bits.z, top));
}

// Orders the crossings of two axes by integers. `order` is the sign of t_b(n_b) - t_a(n_a). `through` says whether the ray is between planes n_a
// and n_a + 1 and between n_b and n_b + 1 at the same time.
void rx_tile_follow(uint n_a, uint n_b, uint g_a, uint g_b, uint d_a, uint d_b, out int order, out bool through) {
    // n_b d_a - n_a d_b less (g_b d_a - g_a d_b) / 2^24, rounded up; `even` if nothing was rounded.
    int64_t start = int64_t(g_b) * int64_t(d_a) - int64_t(g_a) * int64_t(d_b);
    int64_t ahead = int64_t(n_b) * int64_t(d_a) - int64_t(n_a) * int64_t(d_b) - (start >> 24);
    bool even = (uint(start) & 0xffffffu) == 0u;
    bool later = ahead > 0l, same = ahead == 0l;
    order = later ? 1 : same && even ? 0 : -1;
    int64_t back = ahead - int64_t(d_b);
    bool left_a = back < 0l || (back == 0l && !even);
    through = ahead + int64_t(d_a) > 0l && left_a;
}

// By integers: the axis of the face through which a ray enters cell n, counted from the origin's cell in mirrored axes; 3 if it misses that
// cell. g is the origin's place in its own cell in 2^-24 voxels, d the direction on the lattice.
uint rx_tile_settle(uvec3 n, uvec3 g, uvec3 d) {
    int xy, xz, yz;
    bool by_xy, by_xz, by_yz;
    rx_tile_follow(n.x, n.y, g.x, g.y, d.x, d.y, xy, by_xy);
    rx_tile_follow(n.x, n.z, g.x, g.z, d.x, d.z, xz, by_xz);
    rx_tile_follow(n.y, n.z, g.y, g.z, d.y, d.z, yz, by_yz);
    bool x = d.x != 0u, y = d.y != 0u, z = d.z != 0u;
    bool through = (by_xy || !(x && y)) && (by_xz || !(x && z)) && (by_yz || !(y && z)) && (x || n.x == 0u) && (y || n.y == 0u) && (z || n.z == 0u);
    uint axis = x && !(y && (xy > 0 || (xy == 0 && d.y > d.x))) ? 0u : y ? 1u : 2u;
    int order = axis == 0u ? xz : yz;
    if (z && axis < 2u && (order > 0 || (order == 0 && d.z > (axis == 0u ? d.x : d.y)))) axis = 2u;
    return through ? axis : 3u;
}

// Pixel s of the eight that are this invocation's. Group s of 8 x 4 pixels is at (s & 1, s >> 1), and invocation l has its pixel l.
ivec2 rx_tile_pixel(ivec2 tile, uint s) {
    uint lane = gl_LocalInvocationIndex;
    return tile * RX_TILE + ivec2(8u * (s & 1u) + (lane & 7u), 4u * (s >> 1) + (lane >> 3));
}

// The nearest whole number of sixteenths, for x in 0 to 1.
uint rx_tile_sixteenths(float x) {
    return floatBitsToUint(x + 786432.0) & 31u;
}

#endif
