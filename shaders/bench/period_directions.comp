// Directions around a normal, cosine-weighted, as periods: how long a ray takes from plane to plane along u, v and the normal. They cover a
// quarter of the hemisphere; a ray chooses the signs of u and v. engine/oracle/src/bounce.rs has the same numbers.
#version 460
#include <raxel/random.glsl>

layout(local_size_x = 64) in;
layout(std430) writeonly buffer Directions { vec4 directions[]; };

const int RADIUS = 32767;  // length of every direction, but for rounding
const uint TRIES = 16u;    // points that are drawn until one lies in the disk

// Two components across the normal, one along it: a point in a disk, raised to the hemisphere (Malley's method).
ivec3 around(uint seed) {
    ivec2 point = ivec2(0);
    for (uint draw = 1u; draw <= TRIES; ++draw) {
        uint bits = rx_hash(seed + draw);
        ivec2 drawn = ivec2(bits & 0xffffu, bits >> 16) - 32768;
        uvec2 squares = uvec2(drawn * drawn);
        if (squares.x + squares.y < uint(RADIUS * RADIUS)) {
            point = drawn;
            break;
        }
    }
    int square = RADIUS * RADIUS - point.x * point.x - point.y * point.y;
    // The root in floating point is at most one off.
    int up = int(sqrt(float(square)));
    if (up * up > square) --up;
    if ((up + 1) * (up + 1) <= square) ++up;
    return ivec3(point, max(up, 1));
}

// 4096 * RADIUS / length to the nearest whole number, at most 2^24.
float period(int part) {
    uint size = uint(max(abs(part), 8));
    return float(min((4096u * uint(RADIUS) + (size >> 1)) / size, 16777216u));
}

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= uint(directions.length())) return;
    ivec3 way = around(i * 32u);
    directions[i] = vec4(period(way.x), period(way.y), period(way.z), 0.0);
}
