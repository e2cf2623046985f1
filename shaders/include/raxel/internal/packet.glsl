// The steps of rx_trace_tile (packet.glsl), in their order: what a tile is, the walk through the nodes, the leaves of a node, the candidates, and what
// is left. Steps that parallel rays have as well are in tile.glsl.
#ifndef RAXEL_INTERNAL_PACKET_GLSL
#define RAXEL_INTERNAL_PACKET_GLSL

#include "../camera.glsl"
#include "tile.glsl"

const uint RX_TILE_LEAVES = 112u;                // leaves that a tile may look at before its rays are handed on
const uint RX_TILE_STACK = 32u;                  // nodes that may wait, a power of two and at most one for each invocation
const float RX_TILE_LATTICE = 3.7252902984619140625e-9;  // 2^-28, of the longest direction: four times what the lattice takes from a component
const float RX_TILE_SCALE = 16384.0;             // pixels that a place one voxel aside and one voxel deep is from the middle

// Nodes to visit, the next one on top: the place of their corner less RX_TILE_SLACK, relative to the origin, as bits; and their index, the height of
// their children from bit 28 on, and RX_TILE_FULL.
shared uvec4 rx_tile_stack[RX_TILE_STACK];
// Bits of the time at depth 1 until which what is left of a tile is free.
shared uint rx_tile_free;
// Direction through the first pixel, what a pixel to the right and one down add to it (and by what bounds of a direction are widened), fraction of the
// origin; all in mirrored axes.
shared vec4 rx_tile_frame[4];
// What all directions of pixels have in common, and the lattice's part in the error of a time.
shared vec4 rx_tile_camera;
// Places of columns and rows of pixels in view space, see rx_camera_direction.
shared float rx_tile_views[32];

// A tile of a camera's picture.
struct RxPacket {
    ivec2 tile;
    ivec3 cell;         // the camera's
    vec3 frac;
    mat4 view_to_world;
    vec2 tan_half_fov;
    ivec2 size;         // pixels of the output
    float reach;        // length of the longest direction at depth 1
};

// The walk of a tile through the tree, in the mirrored axes of one octant.
struct RxPacketWalk {
    uint alive;                   // bit s: this invocation's pixel of group s has not hit anything yet
    vec3 slow, fast;              // the frustum of the pixels that are left, see rx_packet_frustum
    vec3 voxel_slow, voxel_fast;  // what the place of a voxel in its leaf adds to the times from and to which the frustum can be in it
    uint shown;                   // the rectangle of pixels that are left: first column and row, last column and row
    uint id;                      // the node to visit: index, the height of its children from bit 28 on, RX_TILE_FULL
    vec3 place;                   // of its corner less RX_TILE_SLACK
    uint ones, twos;              // its children that are still to be visited: of the first half, of the second
    uint waiting;                 // nodes on the stack
    uint looked_at;               // leaves
    bool too_much;                // it has ended early, and what is alive is to be handed on
};

// The leaves of a node, on the way through them.
struct RxPacketLeaves {
    vec3 corner;           // of the node, in cells from the origin's
    uvec2 leaf_1, leaf_2;  // masks of this invocation's two leaves; leaf_1 is that of the half in work
    uint set;              // leaves of the half in work that are still to be looked at
    float half_at;         // where that half begins, once there is one
};

// Whether the bounds hold. If not, everything is handed on.
bool rx_packet_proven(RxPacket packet) {
    return RX_TILE_IN_STEP && (1 << world.log2_size) <= RX_TILE_REACH && all(lessThan(packet.frac, vec3(1.0))) && all(greaterThanEqual(packet.frac, vec3(0.0)))
        && !rx_beyond(packet.cell - world.origin, RX_TILE_REACH) && !rx_wraps(packet.cell, world.origin)
        && all(lessThan((0.5 / packet.tan_half_fov + 0.5) * vec2(packet.size) * packet.reach, vec2(RX_TILE_SCALE)));
}

// Half of what bounds of a direction at depth 1 are widened by, on each side.
float rx_packet_slack(RxPacket packet) {
    return 2.0 * RX_TILE_ERROR * packet.reach;
}

// The mirrored axes of the rays through the corners of the tile. `only`: those of all its rays.
uint rx_packet_octant(RxPacket packet, out bool only) {
    const uint lane = gl_LocalInvocationIndex;
    const ivec2 first = packet.tile * RX_TILE;
    vec2 size = vec2(packet.size), pixel_size = 2.0 * packet.tan_half_fov / size, start = (1.0 / size - 1.0) * packet.tan_half_fov;
    vec2 at = start + pixel_size * vec2(first + ivec2((lane & 1u) != 0u ? RX_TILE - 1 : 0, (lane & 2u) != 0u ? RX_TILE - 1 : 0));
    vec3 corner = packet.view_to_world[0].xyz * at.x - packet.view_to_world[1].xyz * at.y - packet.view_to_world[2].xyz;
    uint octant = (RX_TILE_ANY(corner.x < 0.0) ? 1u : 0u) | (RX_TILE_ANY(corner.y < 0.0) ? 2u : 0u) | (RX_TILE_ANY(corner.z < 0.0) ? 4u : 0u);
    vec3 turned = mix(corner, -corner, bvec3((octant & 1u) != 0u, (octant & 2u) != 0u, (octant & 4u) != 0u));
    only = !RX_TILE_ANY(min(turned.x, min(turned.y, turned.z)) < rx_packet_slack(packet));
    return octant;
}

// The length of a direction at depth 1, as rx_packet_direction has it.
float rx_packet_scale(RxPacket packet) {
    return float(packet.size.x) * float(packet.size.y);
}

// Writes rx_tile_views and rx_tile_camera. A barrier has to follow.
void rx_packet_views(RxPacket packet) {
    const uint lane = gl_LocalInvocationIndex;
    const ivec2 first = packet.tile * RX_TILE;
    precise vec2 scale = packet.tan_half_fov * vec2(packet.size.yx);
    precise float far_away = rx_packet_scale(packet);
    precise vec3 back = packet.view_to_world[2].xyz * far_away;
    precise float view_at = lane < 16u ? float(2 * (first.x + int(lane)) + 1 - packet.size.x) * scale.x : float(packet.size.y - 1 - 2 * (first.y + int(lane & 15u))) * scale.y;
    rx_tile_views[lane & 31u] = view_at;
    if (lane == 0u) rx_tile_camera = vec4(back, RX_TILE_LATTICE * packet.reach * far_away);
}

// The direction through this invocation's pixel of group s as rx_camera_direction has it, before it gets the length 1.
vec3 rx_packet_direction(RxPacket packet, uint s) {
    vec2 view = vec2(rx_tile_views[rx_tile_column(s) & 31u], rx_tile_views[rx_tile_row(s) & 31u]);
    precise vec3 right = packet.view_to_world[0].xyz * view.x;
    precise vec3 up = packet.view_to_world[1].xyz * view.y;
    precise vec3 sum = right + up;
    precise vec3 dir = sum - rx_tile_camera.xyz;
    return dir;
}

// Bit s: the ray of this invocation's pixel of group s goes to an octant.
uint rx_packet_rays(RxPacket packet, uint axes) {
    uint rays = 0u;
    for (uint s = 0u; s < 8u; ++s) {
        vec3 dir = rx_packet_direction(packet, s);
        uint there = (dir.x < 0.0 ? 1u : 0u) | (dir.y < 0.0 ? 2u : 0u) | (dir.z < 0.0 ? 4u : 0u);
        if (there == axes) rays |= 1u << s;
    }
    return rays;
}

// Writes rx_tile_project and rx_tile_frame. A barrier has to follow.
void rx_packet_frame(RxPacket packet, RxTileOctant octant) {
    const uint lane = gl_LocalInvocationIndex;
    const ivec2 first = packet.tile * RX_TILE;
    vec3 sign_of = rx_tile_signs(octant);
    vec2 size = vec2(packet.size), pixel_size = 2.0 * packet.tan_half_fov / size;
    if (lane < 3u) {
        // The pixel of a place relative to the camera, counted from the tile's first one, in mirrored axes.
        vec3 ahead = -packet.view_to_world[2].xyz, row = ahead, step_of = vec3(0.0);
        vec2 start = (1.0 / size - 1.0) * packet.tan_half_fov + pixel_size * vec2(first);
        float w = 0.0;
        if (lane == 0u) {
            row = (packet.view_to_world[0].xyz / pixel_size.x + (0.5 * float(packet.size.x - 1) - float(first.x)) * ahead) * 0.0625;
            step_of = packet.view_to_world[0].xyz * start.x - packet.view_to_world[1].xyz * start.y - packet.view_to_world[2].xyz;
        }
        if (lane == 1u) {
            row = (-packet.view_to_world[1].xyz / pixel_size.y + (0.5 * float(packet.size.y - 1) - float(first.y)) * ahead) * 0.0625;
            step_of = packet.view_to_world[0].xyz * pixel_size.x;
            w = rx_packet_slack(packet);
        }
        if (lane == 2u) step_of = -packet.view_to_world[1].xyz * pixel_size.y;
        row *= sign_of;
        rx_tile_project[lane & 3u] = vec4(row, 0.5 * (row.x + row.y + row.z));
        rx_tile_project[3][lane & 3u] = 0.5 * (abs(row.x) + abs(row.y) + abs(row.z));
        rx_tile_frame[lane & 3u] = vec4(step_of * sign_of, w);
    }
    vec3 lattice_frac = floor(packet.frac * 16777216.0) * 5.9604644775390625e-8;
    if (lane == 0u) rx_tile_frame[3] = vec4(rx_tile_fraction(octant, lattice_frac), 0.0);
}

// The frustum of the pixels `rect` (first and last, from the tile's first) as intervals of 1 / direction.
void rx_packet_frustum(ivec4 rect, out vec3 slow, out vec3 fast) {
    float slack = rx_tile_frame[1].w;
    // Half of the sum and of the difference of first and last.
    vec2 to = vec2(rect.zw), from = vec2(rect.xy), middle = 0.5 * (to + from), side = 0.5 * (to - from);
    vec3 right = rx_tile_frame[1].xyz, up = rx_tile_frame[2].xyz;
    vec3 at = fma(vec3(middle.x), right, fma(vec3(middle.y), up, rx_tile_frame[0].xyz));
    vec3 by = fma(vec3(side.x), abs(right), fma(vec3(side.y), abs(up), vec3(slack)));
    vec3 most = max(at + by, vec3(slack)), least = max(at - by, vec3(1.0e-7));
    slow = (1.0 - 2.0 * RX_TILE_ERROR) / most;
    fast = (1.0 + 2.0 * RX_TILE_ERROR) / least;
}

// Narrows the frustum of the walk to a rectangle of pixels.
void rx_packet_narrow(RxTileOctant octant, uint shown, inout RxPacketWalk walk) {
    walk.shown = shown;
    rx_packet_frustum(ivec4(shown & 255u, (shown >> 8) & 255u, (shown >> 16) & 255u, shown >> 24), walk.slow, walk.fast);
    vec3 voxel_at = octant.child_at - rx_tile_frame[3].xyz;
    walk.voxel_slow = (voxel_at - RX_TILE_SLACK) * walk.slow;
    walk.voxel_fast = (voxel_at + (1.0 + RX_TILE_SLACK)) * walk.fast;
}

// The walk at the root.
RxPacketWalk rx_packet_begin(RxPacket packet, RxTileOctant octant, uint alive) {
    RxPacketWalk walk;
    walk.alive = alive;
    rx_packet_narrow(octant, 0x0f0f0000u, walk);
    walk.id = world.root | (((world.log2_size >> 1) - 1u) << 28);
    walk.place = rx_tile_root(octant, packet.cell - world.origin) - (rx_tile_frame[3].xyz + RX_TILE_SLACK);
    walk.ones = 0u;
    walk.twos = 0u;
    walk.waiting = 0u;
    walk.looked_at = 0u;
    walk.too_much = false;
    return walk;
}

// The whole numbers of a place that the origin's fraction was taken from.
ivec3 rx_packet_cell(vec3 place) {
    precise vec3 rounded = (place + rx_tile_frame[3].xyz) + RX_ROUND;
    return floatBitsToInt(rounded) - 0x4b400000;
}

// Without the layers of a leaf that are not ahead of the origin on some axis.
uvec2 rx_packet_ahead(RxTileOctant octant, uvec2 mask, vec3 corner) {
    uvec3 past = uvec3(clamp(-corner, vec3(0.0), vec3(4.0)));
    uint x = (octant.down_x ? 0xfu >> past.x : (0xfu << past.x) & 0xfu) * 0x11111111u;
    uint z = octant.down_z ? 0xffffu >> (4u * past.z) : (0xffffu << (4u * past.z)) & 0xffffu;
    z |= z << 16;
    uint nearest = octant.down_y ? 0xffff0000u : 0x0000ffffu;
    mask &= uvec2(x & z);
    if (past.y > 0u) mask.x &= ~nearest;
    if (past.y > 1u) mask.x = 0u;
    if (past.y > 2u) mask.y &= ~nearest;
    if (past.y > 3u) mask.y = 0u;
    return mask;
}

// Whether the frustum meets two boxes, by the times from and to which it can be in the first. The second is `apart` further along y.
void rx_packet_meets(RxPacketWalk walk, vec3 from, vec3 to, float apart, out bool first, out bool second) {
    float enter = max(max(from.x, from.z), 0.0), leave = min(to.x, to.z);
    first = max(enter, from.y) <= min(leave, to.y);
    second = max(enter, fma(apart, walk.slow.y, from.y)) <= min(leave, fma(apart, walk.fast.y, to.y));
}

// Candidate l of 32 is this invocation's: finds the columns and rows of pixels that it can cover, and makes sets of candidates of them.
void rx_packet_project(vec3 corner, uint taken, uint candidates) {
    const uint lane = gl_LocalInvocationIndex;
    uint code = rx_tile_candidates[(taken + lane) & 127u];
    // 2^23 more than each part of the code.
    vec3 parts = uintBitsToFloat(0x4b000000u | uvec3(code & 255u, (code >> 8) & 255u, code >> 16));
    precise vec3 whole = parts + (corner - 8388608.0);
    precise vec3 q = whole - rx_tile_frame[3].xyz;
    vec3 at = rx_tile_view(q), half_of = rx_tile_project[3].xyz;
    float nearest = at.z - half_of.z, inv_near = 1.0 / nearest, inv_far = 1.0 / (at.z + half_of.z);
    const float up = (0.5 + RX_TILE_MARGIN) * 0.0625, down = (0.5 - RX_TILE_MARGIN) * 0.0625;
    uint columns = rx_tile_span(fma(at.x - half_of.x, inv_far, down), fma(at.x + half_of.x, inv_near, up));
    uint rows = rx_tile_span(fma(at.y - half_of.y, inv_far, down), fma(at.y + half_of.y, inv_near, up));
    uint cover = columns | (rows << 16);
    if (nearest < 1.0) cover = 0xffffffffu;  // beside the camera
    rx_tile_sets(taken + lane < candidates ? cover : 0u);
    rx_tile_corners[(31u - lane) & 31u] = vec4(q, 0.0);
}

void rx_packet_hit(RxPacket packet, RxTileOctant octant, uint s, ivec3 n, uint axis) {
    rx_tile_hit(rx_tile_pixel(packet.tile, s), packet.cell + rx_tile_turned(octant, n), rx_tile_face(octant, axis));
}

// Decides by integers whether the ray of group s hits candidate c.
bool rx_packet_settle(RxPacket packet, RxTileOctant octant, uint s, uint c) {
    vec2 middle = vec2(rx_tile_pixel(packet.tile, s)) + 0.5;
    vec3 dir = rx_camera_direction(packet.view_to_world, packet.tan_half_fov, middle, vec2(packet.size));
    ivec3 n = rx_packet_cell(rx_tile_corners[c & 31u].xyz);
    uint axis = rx_tile_settle(uvec3(n), uvec3(rx_tile_frame[3].xyz * 16777216.0), rx_tile_lattice(dir));
    if (axis < 3u) rx_packet_hit(packet, octant, s, n, axis);
    return axis < 3u;
}

// Tests the pixels that have candidates, one candidate a round. Takes pixels that hit something out of `alive`.
void rx_packet_test(RxPacket packet, RxTileOctant octant, inout uint alive, inout uint rest) {
    uint pending = rx_tile_groups() & alive;
    uint s = 0u, mine = 0u;  // the pixel of the moment, and which candidates it has left
    bool parked = false;     // whether f32 cannot tell what the next one is to it
    for (;;) {
        while (RX_TILE_ANY((pending | mine) != 0u && !parked)) {
            bool fresh = mine == 0u;
            s = fresh ? uint(findLSB(pending)) & 7u : s;
            uint set = rx_tile_lists[rx_tile_column(s) & 31u] & rx_tile_lists[rx_tile_row(s) & 31u];
            set = pending == 0u ? 0u : set;
            mine = fresh ? set : mine;
            pending &= ~(1u << s);
            vec3 inv = 1.0 / max(abs(rx_packet_direction(packet, s)), vec3(1.0e-10));
            // Of a time: of the direction, and of the lattice, which takes most from the smallest component.
            float error = fma(max(inv.x, max(inv.y, inv.z)), rx_tile_camera.w, RX_TILE_ERROR);
            uint c = uint(findMSB(mine)) & 31u;
            vec3 v = rx_tile_corners[c & 31u].xyz;
            RxTileTouch touch = rx_tile_touch(v, inv, error);
            // Conditions by name: && of anything longer than a name becomes a branch.
            bool has = mine != 0u, ahead = touch.enters > 0.0, near = touch.near, loose = error > 0.25, certain = touch.certain, one = touch.one;
            bool touches = near || loose, found = has && touches, sure = certain && one, told = sure || !ahead, hit = found && told;
            parked = found && !told;
            if (hit) {
                alive &= ~(1u << s);
                if (ahead) rx_packet_hit(packet, octant, s, rx_packet_cell(v), touch.axis);
                else rest |= 1u << s;
            }
            mine = parked ? mine : hit ? 0u : mine & ~(1u << c);
        }
        if (!RX_TILE_ANY(parked)) break;
        // Integers tell, seldom.
        if (parked) {
            uint c = uint(findMSB(mine)) & 31u;
            bool hit = rx_packet_settle(packet, octant, s, c);
            if (hit) alive &= ~(1u << s);
            mine = hit ? 0u : mine & ~(1u << c);
            parked = false;
        }
    }
}

// The rectangle of the pixels that are alive, as RxPacketWalk has it.
uint rx_packet_shown(uint alive) {
    uint left = RX_TILE_BALLOT((alive & 0x55u) != 0u), right = RX_TILE_BALLOT((alive & 0xaau) != 0u);
    uint rows_1 = RX_TILE_BALLOT((alive & 0x03u) != 0u), rows_2 = RX_TILE_BALLOT((alive & 0x0cu) != 0u);
    uint rows_3 = RX_TILE_BALLOT((alive & 0x30u) != 0u), rows_4 = RX_TILE_BALLOT((alive & 0xc0u) != 0u);
    left |= left >> 16;
    right |= right >> 16;
    uint columns = ((left | (left >> 8)) & 255u) | (((right | (right >> 8)) & 255u) << 8);
    uint low = rows_4, first_row = 12u, high = rows_1, last_row = 0u;
    if (rows_3 != 0u) low = rows_3, first_row = 8u;
    if (rows_2 != 0u) low = rows_2, first_row = 4u, high = rows_2, last_row = 4u;
    if (rows_1 != 0u) low = rows_1, first_row = 0u;
    if (rows_3 != 0u) high = rows_3, last_row = 8u;
    if (rows_4 != 0u) high = rows_4, last_row = 12u;
    first_row += uint(findLSB(low)) >> 3;
    last_row += uint(findMSB(high)) >> 3;
    return uint(findLSB(columns)) | (first_row << 8) | (uint(findMSB(columns)) << 16) | (last_row << 24);
}

// Tests all whole groups of 32 candidates, and those that are left if there are no more to come. False if no pixel is left.
bool rx_packet_candidates(RxPacket packet, RxTileOctant octant, vec3 corner, uint least, uint candidates, inout uint taken, inout uint alive, inout uint rest) {
    bool some_left = true;
    for (; candidates - taken >= least && some_left; taken = min(taken + 32u, candidates)) {
        rx_packet_project(corner, taken, candidates);
        barrier();
        rx_packet_test(packet, octant, alive, rest);
        some_left = RX_TILE_ANY(alive != 0u);
    }
    return some_left;
}

// Goes on to the next half of the node, without voxels that no ray can hit first.
void rx_packet_next_half(RxTileOctant octant, inout RxPacketWalk walk, inout RxPacketLeaves leaves) {
    bool low = walk.ones != 0u;
    leaves.half_at += 8.0;
    if (low) {
        leaves.set = walk.ones;
        walk.ones = 0u;
    } else {
        leaves.set = walk.twos;
        walk.twos = 0u;
        leaves.leaf_1 = leaves.leaf_2;
    }
    vec3 corner = leaves.corner;
    if (min(min(corner.x, corner.y), corner.z) < 0.0) {
        if (octant.down_y) leaves.leaf_1 = leaves.leaf_1.yx;
        leaves.leaf_1 = rx_packet_ahead(octant, leaves.leaf_1, fma(octant.child_at, vec3(4.0), corner + vec3(0.0, leaves.half_at, 0.0)));
    } else {
        leaves.leaf_1 = rx_tile_bare(octant, leaves.leaf_1);
    }
}

// Makes candidates of the voxels of the next leaf that the frustum touches.
void rx_packet_leaf(RxTileOctant octant, RxPacketWalk walk, inout RxPacketLeaves leaves, inout uint candidates) {
    uint l = uint(findLSB(leaves.set));
    leaves.set &= leaves.set - 1u;
    uvec2 mask = uvec2(RX_TILE_READ(leaves.leaf_1.x, l), RX_TILE_READ(leaves.leaf_1.y, l));
    uvec3 bits = floatBitsToUint(octant.child_at);
    vec3 at = uintBitsToFloat(uvec3(RX_TILE_READ(bits.x, l), RX_TILE_READ(bits.y, l), RX_TILE_READ(bits.z, l)));
    at = fma(at, vec3(4.0), leaves.corner + vec3(0.0, leaves.half_at, 0.0));
    bool touch_1, touch_2;
    rx_packet_meets(walk, fma(at, walk.slow, walk.voxel_slow), fma(at, walk.fast, walk.voxel_fast), 2.0, touch_1, touch_2);
    touch_1 = touch_1 && (mask.x & octant.child_bit) != 0u;
    touch_2 = touch_2 && (mask.y & octant.child_bit) != 0u;
    uint some_1 = RX_TILE_BALLOT(touch_1), some_2 = RX_TILE_BALLOT(touch_2);
    if ((some_1 | some_2) != 0u) {
        uint code = octant.child_code + 4u * RX_TILE_READ(octant.child_code, l) + (leaves.half_at == 0.0 ? 0u : 2048u);
        rx_tile_append(octant, touch_1, touch_2, some_1, some_2, code, candidates);
    }
}

// Goes through the leaves of a node, until all are done or no pixel is left.
void rx_packet_leaves(RxPacket packet, RxTileOctant octant, uvec2 leaf_1, uvec2 leaf_2, inout RxPacketWalk walk, inout uint rest) {
    // The corner of the node, exactly, in cells from the origin's.
    precise vec3 rounded = (walk.place + (rx_tile_frame[3].xyz + RX_TILE_SLACK)) + RX_ROUND;
    precise vec3 corner = rounded - RX_ROUND;
    RxPacketLeaves leaves = RxPacketLeaves(corner, leaf_1, leaf_2, 0u, walk.ones == 0u ? 0.0 : -8.0);
    uint candidates = 0u, taken = 0u;
    for (;;) {
        bool more = RX_TILE_ANY((leaves.set | walk.ones | walk.twos) != 0u);
        uint least = more ? 32u : 1u;
        if (candidates - taken >= least) {
            barrier();
            if (!rx_packet_candidates(packet, octant, corner, least, candidates, taken, walk.alive, rest)) break;
            if (more || walk.waiting != 0u) {
                // The frustum of what is left, for what is still to be visited.
                uint now = rx_packet_shown(walk.alive);
                if (now != walk.shown) rx_packet_narrow(octant, now, walk);
            }
        }
        if (!more) break;
        if (RX_TILE_ANY(leaves.set == 0u)) rx_packet_next_half(octant, walk, leaves);
        rx_packet_leaf(octant, walk, leaves, candidates);
    }
}

// Puts the children of a node on the stack, the first one on top. `at` and `side` are those of this invocation's first child.
void rx_packet_push(RxTileOctant octant, uvec4 node, bool visit_1, bool visit_2, vec3 at, float side, inout RxPacketWalk walk) {
    uint second = uint(bitCount(walk.twos)), top = walk.waiting + uint(bitCount(walk.ones)) + second, level = (walk.id & 0x70000000u) - 0x10000000u;
    walk.too_much = RX_TILE_ANY(top > RX_TILE_STACK);
    if (!walk.too_much) {
        uint child_1, child_2;
        rx_tile_children(octant, node, child_1, child_2);
        bool filled = (node.w & RX_FILLED) != 0u;
        barrier();
        uint slot_1 = top + ~uint(bitCount(walk.ones & octant.below)), slot_2 = walk.waiting + second + ~uint(bitCount(walk.twos & octant.below));
        if (visit_1) rx_tile_stack[slot_1 & (RX_TILE_STACK - 1u)] = uvec4(floatBitsToUint(at), filled ? RX_TILE_FULL | level : child_1 + level);
        if (visit_2) rx_tile_stack[slot_2 & (RX_TILE_STACK - 1u)] = uvec4(floatBitsToUint(vec3(at.x, at.y + 2.0 * side, at.z)), filled ? RX_TILE_FULL | level : child_2 + level);
        walk.waiting = top;
        barrier();
    }
}

// Walks through the tree until no node or no pixel is left, or it was too much.
// Branches here are votes, though all invocations agree anyway: else the compiler keeps each condition in some ten predicates.
void rx_packet_walk(RxPacket packet, RxTileOctant octant, inout RxPacketWalk walk, inout uint rest) {
    for (;;) {
        uint height = (walk.id >> 28) & 7u;
        uvec4 node = rx_tile_node((walk.id & RX_TILE_FULL) != 0u, walk.id & 0x0fffffffu);
        uint mask_1, mask_2;
        rx_tile_masks(octant, node, mask_1, mask_2);
        float side = rx_tile_side(height);
        vec3 at = fma(octant.child_at, vec3(side), walk.place);
        bool visit_1, visit_2;
        rx_packet_meets(walk, at * walk.slow, (at + (side + 2.0 * RX_TILE_SLACK)) * walk.fast, 2.0 * side, visit_1, visit_2);
        visit_1 = visit_1 && (mask_1 & octant.child_bit) != 0u;
        visit_2 = visit_2 && (mask_2 & octant.child_bit) != 0u;
        if (RX_TILE_ANY(visit_1 || visit_2)) {
            walk.ones = RX_TILE_BALLOT(visit_1);
            walk.twos = RX_TILE_BALLOT(visit_2);
            if (RX_TILE_ANY(height > 1u)) {
                rx_packet_push(octant, node, visit_1, visit_2, at, side, walk);
                if (walk.too_much) break;
            } else {
                walk.looked_at += uint(bitCount(walk.ones)) + uint(bitCount(walk.twos));
                walk.too_much = RX_TILE_ANY(walk.looked_at > RX_TILE_LEAVES);
                if (walk.too_much) break;
                uint child_1, child_2;
                uvec2 leaf_1, leaf_2;
                rx_tile_children(octant, node, child_1, child_2);
                rx_tile_leaves(node, visit_1, visit_2, child_1, child_2, leaf_1, leaf_2);
                rx_packet_leaves(packet, octant, leaf_1, leaf_2, walk, rest);
                if (!RX_TILE_ANY(walk.alive != 0u)) break;
            }
        }
        if (!RX_TILE_ANY(walk.waiting != 0u)) break;
        --walk.waiting;
        uvec4 next = rx_tile_stack[walk.waiting & (RX_TILE_STACK - 1u)];
        walk.place = uintBitsToFloat(next.xyz);
        walk.id = next.w;
    }
}

// The time at depth 1 at which the first ray of a walk can come to a node whose corner, less the slack, is at a place.
float rx_packet_enters(RxPacketWalk walk, vec3 at) {
    return max(max(at.x * walk.slow.x, at.y * walk.slow.y), max(at.z * walk.slow.z, 0.0));
}

// The time at depth 1 until which all rays of a walk that was too much are free: none can have come to a node or leaf that is still to be visited.
float rx_packet_free(RxTileOctant octant, RxPacketWalk walk) {
    const uint lane = gl_LocalInvocationIndex;
    barrier();
    if (lane == 0u) rx_tile_free = 0x7f7fffffu;
    barrier();
    float side = rx_tile_side((walk.id >> 28) & 7u);
    vec3 at = fma(octant.child_at, vec3(side), walk.place);
    if (((walk.ones >> lane) & 1u) != 0u) atomicMin(rx_tile_free, floatBitsToUint(rx_packet_enters(walk, at)));
    if (((walk.twos >> lane) & 1u) != 0u) atomicMin(rx_tile_free, floatBitsToUint(rx_packet_enters(walk, vec3(at.x, at.y + 2.0 * side, at.z))));
    if (lane < walk.waiting) atomicMin(rx_tile_free, floatBitsToUint(rx_packet_enters(walk, uintBitsToFloat(rx_tile_stack[lane & (RX_TILE_STACK - 1u)].xyz))));
    barrier();
    return uintBitsToFloat(rx_tile_free);
}

#endif
