// The steps that rx_trace_tile (packet.glsl: rays of a camera) and rx_trace_parallel (parallel.glsl: rays of one direction) share. One subgroup of 32
// invocations traces a tile of 16 x 16 pixels. A shader defines these two functions, and gets one call for each pixel that is decided:
//
//     void rx_tile_hit(ivec2 pixel, ivec3 voxel, uint face);
//     void rx_tile_miss(ivec2 pixel);
#ifndef RAXEL_TILE_GLSL
#define RAXEL_TILE_GLSL

// The older ballots and votes, and shared memory in place of shuffles: what KHR_shader_subgroup has is defined by the invocations that are active, and
// a compiler that cannot prove that all are checks in every round of a loop which they are. Here all of them always are: control flow
// around every ballot, vote and barrier is the same in the whole workgroup.
#extension GL_KHR_shader_subgroup_basic : require
#extension GL_ARB_shader_ballot : require
#extension GL_ARB_shader_group_vote : require
#extension GL_ARB_gpu_shader_int64 : require

#include "walk.glsl"

void rx_tile_hit(ivec2 pixel, ivec3 voxel, uint face);
void rx_tile_miss(ivec2 pixel);

#ifdef RX_TILE_BY_SHARED_MEMORY
// The same through shared memory, whatever the width of a subgroup, by three barriers each: for tests on devices without subgroups of 32 or 64.
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

// What a node is: its index, the height of its children above bit 28, or that all of it is full and has no node.
const uint RX_TILE_FULL = 0x80000000u;

// Every index into shared memory ends with a mask, by which raxel sees that it is inside and compiles no bound for it. No mask
// changes an index.

// Voxels that the frustum touches, x | y << 8 | z << 16 from the corner of their node of 16^3, in mirrored axes: a ring, the first at `taken`.
shared uint rx_tile_candidates[128];
// A word of each invocation, on the way from candidates to their sets.
shared uint rx_tile_words[32];
// The same, and then which candidates each column (from 0 on) and each row (from 16 on) of pixels has.
shared uint rx_tile_lists[32];
// Places of up to 32 candidates, by their bit in a set.
shared vec4 rx_tile_corners[32];
// From places to pixels, in sixteenths.
shared vec4 rx_tile_project[4];

// Pixel s of the eight that are this invocation's. Group s of 8 x 4 pixels is at (s & 1, s >> 1), and invocation l has its pixel l.
ivec2 rx_tile_pixel(ivec2 tile, uint s) {
    uint lane = gl_LocalInvocationIndex;
    return tile * RX_TILE + ivec2(8u * (s & 1u) + (lane & 7u), 4u * (s >> 1) + (lane >> 3));
}

// Bit s: this invocation's pixel of group s is on the output.
uint rx_tile_on_output(ivec2 tile, ivec2 size) {
    ivec2 there = size - rx_tile_pixel(tile, 0u);
    uint rays = (there.x > 0 ? 0x55u : 0u) | (there.x > 8 ? 0xaau : 0u);
    return rays & ((there.y > 0 ? 0x03u : 0u) | (there.y > 4 ? 0x0cu : 0u) | (there.y > 8 ? 0x30u : 0u) | (there.y > 12 ? 0xc0u : 0u));
}

// The octant that the rays of a tile go to, and the two of the 64 children of any node that are this invocation's: child l and child l + 32, in mirrored
// order. A leaf has voxels in place of children. `first half` and `second half` of a node are the children below 32 and from there on.
struct RxTileOctant {
    uint axes;                    // bit a: axis a is mirrored
    bool down_x, down_y, down_z;  // the same
    vec3 child_at;                // place of child l in its node, in children; child l + 32 is 2 further along y
    uint child_code;              // the same, as in rx_tile_candidates
    uint child_bit;               // the bit of child l in its half of the node's mask
    uint below;                   // bits of the invocations before this one
};

// The bit of child l, or l + 32, in its half of a node's mask.
uint rx_tile_child_bit(uint l, bool down_x, bool down_y, bool down_z) {
    return 1u << (l ^ ((down_x ? 3u : 0u) | (down_z ? 12u : 0u) | (down_y ? 16u : 0u)));
}

RxTileOctant rx_tile_octant(uint axes) {
    const uint lane = gl_LocalInvocationIndex;
    bool down_x = (axes & 1u) != 0u, down_y = (axes & 2u) != 0u, down_z = (axes & 4u) != 0u;
    uvec3 child = uvec3(lane & 3u, lane >> 4, (lane >> 2) & 3u);
    uint code = child.x | (child.y << 8) | (child.z << 16);
    return RxTileOctant(axes, down_x, down_y, down_z, vec3(child), code, rx_tile_child_bit(lane, down_x, down_y, down_z), (1u << lane) - 1u);
}

// 1 on axes that are not mirrored, -1 on those that are.
vec3 rx_tile_signs(RxTileOctant octant) {
    return vec3(octant.down_x ? -1.0 : 1.0, octant.down_y ? -1.0 : 1.0, octant.down_z ? -1.0 : 1.0);
}

// A distance in cells, out of mirrored axes.
ivec3 rx_tile_turned(RxTileOctant octant, ivec3 n) {
    return ivec3(octant.down_x ? -n.x : n.x, octant.down_y ? -n.y : n.y, octant.down_z ? -n.z : n.z);
}

// A fraction of a cell, into mirrored axes.
vec3 rx_tile_fraction(RxTileOctant octant, vec3 frac) {
    return vec3(octant.down_x ? 1.0 - frac.x : frac.x, octant.down_y ? 1.0 - frac.y : frac.y, octant.down_z ? 1.0 - frac.z : frac.z);
}

// Where the corner of the world's cube is, seen from a cell that is `from` away from it, in mirrored axes.
vec3 rx_tile_root(RxTileOctant octant, ivec3 from) {
    int last = int((1u << world.log2_size) - 1u);
    return -vec3(octant.down_x ? last - from.x : from.x, octant.down_y ? last - from.y : from.y, octant.down_z ? last - from.z : from.z);
}

// The face by which a ray enters a voxel, by its axis; RX_FACE_INSIDE for axis 3.
uint rx_tile_face(RxTileOctant octant, uint axis) {
    return 2u * axis + ((octant.axes >> axis) & 1u);
}

// 4^height: voxels along an edge of a child of a node, whose children have this height.
float rx_tile_side(uint height) {
    return uintBitsToFloat((height << 24) + 0x3f800000u);
}

#ifdef RX_LAYOUT_TREE64
// A node of the tree; one that is full is in no buffer.
uvec4 rx_tile_node(bool full, uint index) {
    uvec4 node = uvec4(0xffffffffu, 0xffffffffu, 0u, RX_FILLED);
    if (!full) node = world.quads[index];
    return node;
}

// The masks of a node's halves, in mirrored order.
void rx_tile_masks(RxTileOctant octant, uvec4 node, out uint mask_1, out uint mask_2) {
    mask_1 = octant.down_y ? node.y : node.x;
    mask_2 = octant.down_y ? node.x : node.y;
}

// Where the two children of this invocation are, if the node has them.
void rx_tile_children(RxTileOctant octant, uvec4 node, out uint child_1, out uint child_2) {
    uint mask_1, mask_2, half_count = uint(bitCount(node.x));
    rx_tile_masks(octant, node, mask_1, mask_2);
    child_1 = node.z + (octant.down_y ? half_count : 0u) + uint(bitCount(mask_1 & (octant.child_bit - 1u)));
    child_2 = node.z + (octant.down_y ? 0u : half_count) + uint(bitCount(mask_2 & (octant.child_bit - 1u)));
}

// The masks of those leaves of a node that this invocation's children are, if they are visited.
void rx_tile_leaves(uvec4 node, bool visit_1, bool visit_2, uint child_1, uint child_2, out uvec2 leaf_1, out uvec2 leaf_2) {
    leaf_1 = uvec2(0xffffffffu);
    leaf_2 = uvec2(0xffffffffu);
    if ((node.w & RX_FILLED) == 0u) {
        if (visit_1) leaf_1 = rx_leaf(child_1);
        if (visit_2) leaf_2 = rx_leaf(child_2);
    }
}
#endif

uint rx_tile_rotate(uint x, uint by) {
    return (x << by) | (x >> (32u - by));
}

// A leaf's mask, halves in mirrored order, without voxels that no ray can hit first: those whose seven neighbours towards the origin are solid.
uvec2 rx_tile_bare(RxTileOctant octant, uvec2 mask) {
    if (octant.down_y) mask = mask.yx;
    uint step_x = octant.down_x ? 31u : 1u, within_x = octant.down_x ? 0x77777777u : 0xeeeeeeeeu;
    uint step_z = octant.down_z ? 28u : 4u, within_z = octant.down_z ? 0x0fff0fffu : 0xfff0fff0u;
    uint a = mask.x, b = mask.y, second = octant.down_y ? 0x0000ffffu : 0xffff0000u;
    a &= rx_tile_rotate(a, step_x) & within_x;
    b &= rx_tile_rotate(b, step_x) & within_x;
    a &= rx_tile_rotate(a, step_z) & within_z;
    b &= rx_tile_rotate(b, step_z) & within_z;
    uint s = rx_tile_rotate(a, 16u), t = rx_tile_rotate(b, 16u);
    return mask & ~uvec2(a & s & second, b & ((t & second) | (s & ~second)));
}

// Appends voxels of a leaf to the candidates: those that the frustum touches, of this invocation's two (`touch_1`, `touch_2`) and by ballot of all
// (`some_1`, `some_2`). `code` is the place of this invocation's first one.
void rx_tile_append(RxTileOctant octant, bool touch_1, bool touch_2, uint some_1, uint some_2, uint code, inout uint candidates) {
    if (touch_1) rx_tile_candidates[(candidates + uint(bitCount(some_1 & octant.below))) & 127u] = code;
    candidates += uint(bitCount(some_1));
    if (touch_2) rx_tile_candidates[(candidates + uint(bitCount(some_2 & octant.below))) & 127u] = code + 512u;
    candidates += uint(bitCount(some_2));
}

// The nearest whole number of sixteenths, for x in 0 to 1.
uint rx_tile_sixteenths(float x) {
    return floatBitsToUint(x + 786432.0) & 31u;
}

// Bits of the columns, or rows, of pixels between two places in sixteenths of a tile.
uint rx_tile_span(float from, float to) {
    to = clamp(to, 0.0, 1.0);
    from = min(clamp(from, 0.0, 1.0), to);
    return (1u << rx_tile_sixteenths(to)) - (1u << rx_tile_sixteenths(from));
}

// A place by rx_tile_project: x and y are z times those of its pixel.
vec3 rx_tile_view(vec3 at) {
    vec4 row_x = rx_tile_project[0], row_y = rx_tile_project[1], row_z = rx_tile_project[2];
    return vec3(fma(row_x.x, at.x, fma(row_x.y, at.y, fma(row_x.z, at.z, row_x.w))), fma(row_y.x, at.x, fma(row_y.y, at.y, fma(row_y.z, at.z, row_y.w))),
                fma(row_z.x, at.x, fma(row_z.y, at.y, fma(row_z.z, at.z, row_z.w))));
}

// Of candidate l, invocation l has `set`: bit i for column i of pixels, bit 16 + i for row i. Makes of it rx_tile_lists[i], the candidates of column i, and
// rx_tile_lists[16 + i], those of row i: bit 31 - l for candidate l, so that the first is the highest bit. A barrier has to follow.
void rx_tile_sets(uint set) {
    const uint lane = gl_LocalInvocationIndex;
    // Bit p + l of each word is first made its bit p; then bit p moves on by p invocations, first by the eights in p, then by the twos, then by one;
    // then words turn.
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

// Where the column, and the row, of this invocation's pixel of group s are in arrays of 16 columns and 16 rows.
uint rx_tile_column(uint s) {
    return (((s & 1u) << 3) | (gl_LocalInvocationIndex & 7u)) & 31u;
}

uint rx_tile_row(uint s) {
    return (16u | ((s & 6u) << 1) | (gl_LocalInvocationIndex >> 3)) & 31u;
}

// Bit s: this invocation's pixel of group s has candidates.
uint rx_tile_groups() {
    const uint lane = gl_LocalInvocationIndex;
    uint groups = 0u;
    for (uint i = 0u; i < 4u; ++i) {
        uint row = rx_tile_lists[(16u | (lane >> 3) | (i << 2)) & 31u];
        if ((rx_tile_lists[lane & 7u] & row) != 0u) groups |= 1u << (2u * i);
        if ((rx_tile_lists[8u + (lane & 7u)] & row) != 0u) groups |= 2u << (2u * i);
    }
    return groups;
}

// How a ray passes a voxel, as far as f32 can tell.
struct RxTileTouch {
    float enters;  // time at which it enters, as if it met the voxel
    bool near;     // it may pass through the voxel, or does
    bool certain;  // it passes through the voxel
    bool one;      // it enters by the face of `axis`, if it does
    uint axis;
};

// `v` is the voxel's place from the ray's start, `inv` is 1 / direction, and `error` that of a time, relative to it.
RxTileTouch rx_tile_touch(vec3 v, vec3 inv, float error) {
    // Not v * inv + inv: where that is not fused, it cancels.
    vec3 t_in = v * inv, t_out = (v + 1.0) * inv;
    float enters = max(t_in.x, max(t_in.y, t_in.z)), leaves = min(t_out.x, min(t_out.y, t_out.z));
    float inside = leaves - enters, limit = enters - abs(enters) * error, bound = leaves * error;
    bool x = t_in.x >= limit, y = t_in.y >= limit, z = t_in.z >= limit;
    bool one = (x ? 1u : 0u) + (y ? 1u : 0u) + (z ? 1u : 0u) == 1u;
    return RxTileTouch(enters, inside >= -bound, inside > bound, one, x ? 0u : y ? 1u : 2u);
}

// A direction on the lattice, without its signs.
uvec3 rx_tile_lattice(vec3 dir) {
    uvec3 bits = floatBitsToUint(dir);
    uint top = rx_lattice_top(dir);
    return uvec3(rx_lattice_component(bits.x, top), rx_lattice_component(bits.y, top), rx_lattice_component(bits.z, top));
}

// How the crossings of two axes follow each other, by integers. `order`: the sign of t_b(n_b) - t_a(n_a); `through`: whether the ray is between
// planes n_a and n_a + 1 and between n_b and n_b + 1 at the same time.
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

// By integers: the axis of the face by which a ray comes into cell n, counted from the origin's own in mirrored axes; 3 if it does not pass
// through that cell. g is the origin's place in its own cell in 2^-24 voxels, d the direction on the lattice.
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

#endif
