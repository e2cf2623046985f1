// The exact walk with an early-out. It leaves a block of 4^3 at once if a table of masks shows no solid cell on the
// line. With a conservative table no hit changes. The original method has lines between the centres of squares, and
// loses voxels at the edge of a line's way.
#ifndef RAXEL_MARCH_RAYMASK_GLSL
#define RAXEL_MARCH_RAYMASK_GLSL

#include "raymask_table.glsl"

// Such a layout's rx_look keeps the mask of the block that it has looked into, unless that is empty, in `rx_looked_mask`.
#ifndef RX_LAYOUT_BRICKMAP
#error "RX_MARCH_RAYMASK needs a layout with masks of 4 x 4 x 4 voxels: bind `world` to world.brickmap"
#endif

layout(std430) readonly buffer RxRayMasks {
    uvec2 masks[];
} rayMasks;

// A mask of a block, bit x + 4z + 16y, as it is in the walk's mirrored coordinates.
uvec2 rx_mirror_mask(uvec2 mask, uvec3 flip) {
    if ((flip.x & 1u) != 0u) {
        mask = ((mask & 0x11111111u) << 3) | ((mask & 0x22222222u) << 1) | ((mask >> 1) & 0x22222222u) | ((mask >> 3) & 0x11111111u);
    }
    if ((flip.z & 1u) != 0u) {
        mask = ((mask & 0x000f000fu) << 12) | ((mask & 0x00f000f0u) << 4) | ((mask >> 4) & 0x00f000f0u) | ((mask >> 12) & 0x000f000fu);
    }
    return (flip.y & 1u) != 0u ? (mask.yx << 16) | (mask.yx >> 16) : mask;
}

// The block that needs no asking at the start of a walk: one that it begins in, not by a face.
uvec3 rx_raymask_block(RxWalk walk) {
    return (walk.axes & 7u) == 0u ? walk.q >> 2 : uvec3(0xffffffffu);
}

// Whether the table shows that the ray misses all solid voxels of the block of 4^3 that it just entered. False for the block `asked`,
// which then becomes this one. Call it after rx_look.
bool rx_raymask_misses(RxWalk walk, inout uvec3 asked) {
    if (walk.q >> 2 == asked) return false;
    asked = walk.q >> 2;
    vec3 from_entry = vec3(ivec3((asked << 2) - walk.entry));
    vec3 exits = mix((from_entry + 3.5 - walk.start) * walk.inv, vec3(RX_NEVER), equal(walk.inv, vec3(0.0)));
    uint leave = exits.x <= exits.y && exits.x <= exits.z ? 0u : exits.y <= exits.z ? 1u : 2u;
    // Of the axes crossed together, one through which the ray entered the block: others may lie within it.
    bvec3 at_face = equal(walk.q & 3u, uvec3(0u));
    uint faces = (at_face.x ? 1u : 0u) | (at_face.y ? 2u : 0u) | (at_face.z ? 4u : 0u);
    if ((walk.axes & faces) == 0u) return false;
    uint enter = uint(findLSB(walk.axes & faces));
    vec3 in_place = walk.t * walk.d + walk.start + 0.5, out_place = exits[leave] * walk.d + walk.start + 0.5;
    // Places are good to 2^-20 of the way. If a slow axis leaves the block, the error grows by the ratio of the fastest axis to the
    // slow one, and may exceed a mask's margin.
    float way = max(out_place.x, max(out_place.y, out_place.z)) + 1.0, fastest = max(walk.d.x, max(walk.d.y, walk.d.z));
    if (way * fastest >= 16384.0 * walk.d[leave]) return false;
    uint enter_square = rx_raymask_square(in_place - from_entry, enter), leave_square = rx_raymask_square(out_place - from_entry, leave);
    uvec2 passed = rayMasks.masks[rx_raymask_index(enter, enter_square, leave, leave_square)];
    return (passed & rx_mirror_mask(rx_looked_mask, rx_walk_flip(walk, 3u))) == uvec2(0u);
}

#endif
