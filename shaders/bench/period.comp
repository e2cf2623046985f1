// One period ray leaves each hit in a random direction, cosine-weighted around the normal. Only whole numbers make a ray, so its bits are the
// same on every device. engine/oracle/src/bounce.rs makes the same rays, and judges their hits. Subgroups take tiles of pixels off a counter,
// and lanes whose rays have ended take the next pixel.
#version 460
layout(local_size_x = 128) in;

#include <raxel/refill.glsl>
#include <raxel/random.glsl>

layout(rgba32i) uniform readonly iimage2D hits;     // of the pixels' own rays
layout(rg32f) uniform readonly image2D places;      // RxHit.uv
layout(std430) buffer Taken { uint tilesTaken; };
layout(std430) readonly buffer Directions { vec4 directions[]; };  // of period_directions.comp
layout(rgba32i) uniform writeonly iimage2D outHit;  // voxel; face, or -1 where nothing is hit

const uint TILE = 16u;     // pixels along a side of a tile

// When the first plane is crossed by a ray that has `ahead` / 4096 of a voxel to go.
float first(float period, uint ahead) {
    return max(floor((period * float(ahead)) * (1.0 / 4096.0)), 1.0);
}

// Tiles are counted in squares of four by four of them, so that those taken at the same time lie close together.
ivec2 pixel_of(uint item) {
    uint across = (uint(imageSize(outHit).x) + 4u * TILE - 1u) / (4u * TILE);
    uint tile = item / (TILE * TILE), place = item % (TILE * TILE), square = tile / 16u;
    uvec2 corner = uvec2(square % across, square / across) * 4u + uvec2(tile % 4u, tile / 4u % 4u);
    return ivec2(corner * TILE + uvec2(place % TILE, place / TILE));
}

bool rx_next_items(out uint first) {
    first = TILE * TILE * atomicAdd(tilesTaken, 1u);
    return pixel_of(first).y < (imageSize(outHit).y + 4 * int(TILE) - 1) / (4 * int(TILE)) * (4 * int(TILE));
}

bool rx_next_ray(uint item, out RxPeriodRay ray) {
    ivec2 pixel = pixel_of(item), size = imageSize(outHit);
    if (any(greaterThanEqual(pixel, size))) return false;
    ivec4 from = imageLoad(hits, pixel);
    uint face = uint(from.w) & 7u;
    if (from.w < 0 || face == RX_FACE_INSIDE) {
        imageStore(outHit, pixel, ivec4(0, 0, 0, -1));
        return false;
    }
    uint draw = rx_hash(uint(pixel.y * size.x + pixel.x));
    // Along u and v of the face, and along its normal.
    vec3 periods = directions[draw % 4096u].xyz;
    bvec2 down = notEqual(uvec2(draw) & uvec2(4096u, 8192u), uvec2(0u));
    uvec2 place = uvec2(imageLoad(places, pixel).xy * 4096.0);
    bool up = (face & 1u) != 0u;
    uint axis = rx_face_axis(face);
    uvec2 ahead = mix(4096u - min(place, uvec2(4095u)), max(place, uvec2(1u)), down);
    vec3 firsts = vec3(first(periods.x, ahead.x), first(periods.y, ahead.y), periods.z);
    uvec3 downs = uvec3(down, !up);
    ray.cell = from.xyz + rx_face_step(face);
    ray.period = axis == 0u ? periods.zxy : axis == 1u ? periods.xzy : periods;
    ray.first = axis == 0u ? firsts.zxy : axis == 1u ? firsts.xzy : firsts;
    uvec3 bits = axis == 0u ? downs.zxy : axis == 1u ? downs.xzy : downs;
    ray.octant = bits.x | (bits.y << 1) | (bits.z << 2);
    return true;
}

void rx_ray_traced(uint item, bool found, RxPeriodHit hit) {
    imageStore(outHit, pixel_of(item), found ? ivec4(hit.voxel, hit.face) : ivec4(0, 0, 0, -1));
}

void main() {
    rx_trace_items();
}
