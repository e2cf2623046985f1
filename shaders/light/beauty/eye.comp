// Exposure: the mean of the logarithms between the darker two fifths and the brightest twentieth becomes mid-grey, partly, so that night
// stays darker than day. The eye takes about a second to get used to light, and some seconds to get used to the dark. It starts over where
// the camera jumps. A bin of the histogram for each thread.
#version 460
#include "../frame.glsl"

layout(local_size_x = 256) in;
layout(std430) readonly buffer Histogram { uint bins[256]; };
layout(std430) buffer Eye { float exposure; float age; };   // age: seconds since the camera jumped
layout(push_constant) uniform Push { mat4 world_to_view; ivec3 cell; vec3 frac; float delta; } push;   // the camera of the last frame

const float FROM = 0.40, UNTIL = 0.95;
const float TO_BRIGHT = 2.5, TO_DARK = 0.8;     // of the way, by second
const float FIRST = 3.0;                        // power of the age that weighs the frames after a jump
const uint RESTS = 512u;                        // frames at rest after which this pass stops
const float LEAP = 16.0, FASTEST = 600.0;       // voxels, and voxels a second: no flight goes farther in a frame
const float TURN = 0.5;                         // cosine of an angle that no camera turns by in a frame

shared uint below[256];     // pixels in this bin and all darker ones
shared vec2 parts[256];     // sum of logarithms, and their number

bool jumped() {
    vec3 way = vec3(frame.camera_cell - push.cell) + (frame.camera_frac - push.frac);
    vec3 before = vec3(push.world_to_view[0].z, push.world_to_view[1].z, push.world_to_view[2].z);
    return length(way) > LEAP + FASTEST * push.delta || dot(frame.view_to_world[2].xyz, before) < TURN;
}

void main() {
    uint i = gl_LocalInvocationIndex, mine = bins[i];
    below[i] = mine;
    barrier();
    for (uint step = 1u; step < 256u; step *= 2u) {
        uint more = i >= step ? below[i - step] : 0u;
        barrier();
        below[i] += more;
        barrier();
    }
    float all = float(below[255]), from = max(float(below[i] - mine), FROM * all), to = min(float(below[i]), UNTIL * all), counted = max(to - from, 0.0);
    parts[i] = vec2(counted * ((float(i) + 0.5) / 256.0 * 28.0 - 16.0), counted);
    barrier();
    for (uint half_way = 128u; half_way > 0u; half_way /= 2u) {
        if (i < half_way) parts[i] += parts[i + half_way];
        barrier();
    }
    if (i != 0u) return;
    float level = parts[0].x / max(parts[0].y, 1.0);
    float goal = clamp(exp2(-0.75 * level - 1.35), 0.02, 128.0);
    if (exposure == 0.0 || jumped()) age = 0.0;
    // The view after a jump has noise at first, so later frames count for more. A sum of powers, which the length of a frame does not
    // change.
    float share = age == 0.0 ? 1.0 : 1.0 - pow(age / (age + push.delta), FIRST);
    share = max(share, 1.0 - exp(-push.delta * (goal < exposure ? TO_BRIGHT : TO_DARK)));
    // A picture at rest has its goal when this pass stops, however short the frames are. While time stands still, the exposure stays.
    if (push.delta > 0.0) share = max(share, 1.0 / float(RESTS - min(frame.still, RESTS - 1u)));
    if (share > 0.0) exposure = share == 1.0 ? goal : exp2(mix(log2(exposure), log2(goal), share));
    age += push.delta;
}
