// Steps of fixed length with jumps over empty blocks. If a sample is solid, the march steps back and goes on voxel by voxel. So the face and
// t are right, and it hits the first voxel of that last step. Corners that lie between two empty samples are still cut. This is how Lum
// marches (platonvin/lum; "How i render voxels").
#ifndef RAXEL_MARCH_ROLLBACK_GLSL
#define RAXEL_MARCH_ROLLBACK_GLSL

#include "dda.glsl"

#ifndef RX_MARCH_STEP
#define RX_MARCH_STEP 0.25  // voxels
#endif
#ifndef RX_MARCH_JUMP
#define RX_MARCH_JUMP 2u    // log2 of the smallest empty cube that is jumped over
#endif

// `solid` was hit at t; from `before` on there may be others in front of it.
bool rx_roll_back(RxLine line, RxRay ray, float before, float t, ivec3 solid, uint material, inout RxHit hit) {
    RxLine back = line;
    back.t = before;
    back.t_end = t;
    if (before > line.t) rx_line_entry(line, rx_line_cell(line, before), back.axis);
    if (rx_dda(back, ray, hit)) return true;
    // Rounding let the walk pass it by.
    uint axis;
    float entry = rx_line_entry(line, solid, axis);
    return rx_line_hit(line, ray, solid, max(entry, before), axis, material, hit);
}

// First solid voxel along a ray, by fixed steps, jumps over empty blocks, and a walk back.
bool rx_march(RxRay ray, out RxHit hit) {
    hit = RX_NO_HIT;
    RxLine line;
    if (!rx_line_begin(ray, line)) return false;
    float step_t = RX_MARCH_STEP / length(line.dir);
    float before = line.t, t = line.t;  // up to `before` all samples are empty
    while (hit.steps < RX_MARCH_ROUNDS) {
        ivec3 cell = rx_line_cell(line, t);
        uint log2_free;
        uint material = rx_look(world.origin + cell, log2_free);
        ++hit.steps;
        if (material != 0u) return rx_roll_back(line, ray, before, t, cell, material, hit);
        before = t;
        if (log2_free >= RX_MARCH_JUMP) {
            vec3 exits = rx_line_exits(line, cell, log2_free);
            before = max(t, min(exits.x, min(exits.y, exits.z)));
        }
        if (before >= line.t_end) return false;
        t = min(before + step_t, line.t_end);
    }
    return false;
}

#endif
