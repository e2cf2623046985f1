// Light between the centres of neighbouring faces of one plane. Only faces seen in this frame take part, so each is exposed. No wall stands
// between two exposed faces side by side. Across a corner, the light passes one of the two faces beside it. So nothing leaks. Needs cells.glsl
// and queue.glsl; `height` is that of the picture.

#include "beside.glsl"
#include "soft.glsl"

// The shown light of a face; its own if none has been shared yet.
vec3 shown(uint slot) {
    uvec2 word = soft[slot];
    return word == uvec2(0u) ? light[slot].rgb : soft_unpack(word);
}

// `uv` is a place on the face of `voxel`.
vec3 blended(uint slot, ivec3 voxel, vec2 uv, float height) {
    vec3 own = shown(slot);
    RxFaceKey key;
    ivec3 cell;
    uint face, part;
    if (!rx_face_in_slot(slot, key)) return own;
    cell_of_key(key, cell, face, part);
    if (cell_pixels(cell, face, part, height) < queue_narrow()) return own;
    vec2 from_middle = cell_place(voxel, face, uv, part) - 0.5;
    ivec2 step = ivec2(from_middle.x < 0.0 ? -1 : 1, from_middle.y < 0.0 ? -1 : 1);
    vec2 share = abs(from_middle);

    uint along = seen_beside(cell, face, part, ivec2(step.x, 0), 0u), across = seen_beside(cell, face, part, ivec2(0, step.y), 0u);
    vec3 a = along == RX_NO_FACE ? own : shown(along);
    vec3 b = across == RX_NO_FACE ? own : shown(across);
    vec3 c = 0.5 * (a + b);
    if (along != RX_NO_FACE || across != RX_NO_FACE) {
        uint diagonal = seen_beside(cell, face, part, step, 0u);
        if (diagonal != RX_NO_FACE) c = shown(diagonal);
    }
    return mix(mix(own, a, share.x), mix(b, c, share.x), share.y);
}
