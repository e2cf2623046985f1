// The light of the last frame's cells on a face, for path.glsl. The shader has `push.ready` and `push.cell`. Needs
// light/face_cache/cache.glsl.
#include "cell.glsl"

#define PATH_KEPT

vec4 kept(RxHit hit) {
    float height = float(imageSize(hits).y);
    uint level = cell_level(hit.voxel, push.cell, height);
    // A cell that has no light yet is looked for one level up, where cells fill earlier.
    for (uint up = 0u; up < 2u && level < CELL_LEVELS; ++up, ++level) {
        // Nearby, a cell is too coarse: its centre may lie in the dark where the place is lit.
        if (level > 0u && hit.t < 1.7320508 * float(1u << level)) break;
        if (!cell_fits(hit.voxel, hit.face, level)) continue;
        uint slot = rx_face_find(cell_key(hit.voxel, hit.face, level));
        if (slot == RX_NO_FACE || generation[slot] != state.generation || light[slot].w < float(push.ready)) continue;
        return light[slot];
    }
    return vec4(0.0);
}
