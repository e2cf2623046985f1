// Light between the middles of neighbouring faces of one plane. Only faces that are seen in this frame take part, so each of them is bare;
// two bare faces side by side have no wall between them, and across a corner the light goes by one of the two faces beside it. So
// nothing leaks. Needs across.glsl and queue.glsl; `height` is that of the picture.

#include "beside.glsl"
#include "soft.glsl"

// What a face shows; what it keeps where nothing has been shared yet.
vec3 shown(uint slot) {
    uvec2 word = soft[slot];
    return word == uvec2(0u) ? light[slot].rgb : soft_unpack(word);
}

vec3 blended(uint slot, vec2 uv, float height) {
    vec3 own = shown(slot);
    RxFaceKey key;
    ivec3 voxel;
    uint face, part;
    if (!rx_face_in_slot(slot, key)) return own;
    rx_face_of(key, face_box(), voxel, face, part);
    if (pixels_across(voxel, face, height) < queue_narrow()) return own;
    vec3 corner = rx_face_part(part);
    vec2 from_middle = (uv - corner.xy) / corner.z - 0.5;
    ivec2 step = ivec2(from_middle.x < 0.0 ? -1 : 1, from_middle.y < 0.0 ? -1 : 1);
    vec2 share = abs(from_middle);

    uint along = seen_beside(voxel, face, part, ivec2(step.x, 0), 0u), across = seen_beside(voxel, face, part, ivec2(0, step.y), 0u);
    vec3 a = along == RX_NO_FACE ? own : shown(along);
    vec3 b = across == RX_NO_FACE ? own : shown(across);
    vec3 c = 0.5 * (a + b);
    if (along != RX_NO_FACE || across != RX_NO_FACE) {
        uint diagonal = seen_beside(voxel, face, part, step, 0u);
        if (diagonal != RX_NO_FACE) c = shown(diagonal);
    }
    return mix(mix(own, a, share.x), mix(b, c, share.x), share.y);
}
