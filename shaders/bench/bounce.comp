// One ray leaves each hit in a random direction, cosine-weighted around the normal. Only whole numbers make a ray, so its bits are the same on
// every device. engine/oracle/src/bounce.rs makes the same rays, and judges their hits.
#version 460
#include <raxel/world.glsl>
#include <raxel/random.glsl>

layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba32i) uniform readonly iimage2D hits;     // of the pixels' own rays
layout(rg32f) uniform readonly image2D places;      // RxHit.uv
layout(rgba32i) uniform writeonly iimage2D outHit;  // voxel; face + 8 * material, or -1 where nothing is hit

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

RxRay leave(ivec3 voxel, uint face, vec2 uv, ivec3 way) {
    if (face == RX_FACE_INSIDE) return rx_ray(voxel, vec3(uv, 0.5), vec3(way));
    ivec3 u, v;
    rx_face_tangents(face, u, v);
    return rx_ray_from_face(voxel, face, uv, vec3(way.x * u + way.y * v + way.z * rx_face_step(face)));
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    ivec2 size = imageSize(outHit);
    if (any(greaterThanEqual(pixel, size))) return;

    ivec4 from = imageLoad(hits, pixel);
    RxHit hit;
    bool found = false;
    if (from.w >= 0) {
        uint seed = rx_hash(uint(pixel.y * size.x + pixel.x)) & 0xffffffe0u;
        found = rx_trace(leave(from.xyz, uint(from.w) & 7u, imageLoad(places, pixel).xy, around(seed)), hit);
    }
    imageStore(outHit, pixel, found ? ivec4(hit.voxel, hit.face + 8u * hit.material) : ivec4(0, 0, 0, -1));
}
