// Steps of fixed length, a look at each. Voxels between two samples are missed: corners are cut, and thin walls have holes.
#ifndef RAXEL_MARCH_FIXED_GLSL
#define RAXEL_MARCH_FIXED_GLSL

#include "line.glsl"

#ifndef RX_MARCH_STEP
#define RX_MARCH_STEP 0.25  // voxels
#endif

// The face is the one by which the line enters the voxel; t is the sample's, up to a step late.
bool rx_march(RxRay ray, out RxHit hit) {
    hit = RX_NO_HIT;
    RxLine line;
    if (!rx_line_begin(ray, line)) return false;
    float step_t = RX_MARCH_STEP / length(line.dir);
    float t = line.t;
    for (; hit.steps < RX_MARCH_ROUNDS && t <= line.t_end; t += step_t) {
        ivec3 cell = rx_line_cell(line, t);
        uint log2_free;
        uint material = rx_look(world.origin + cell, log2_free);
        ++hit.steps;
        if (material == 0u) continue;
        uint axis = line.axis;
        if (t > line.t) rx_line_entry(line, cell, axis);
        return rx_line_hit(line, ray, cell, t, axis, material, hit);
    }
    return false;
}

#endif
