// Walks from empty cube to empty cube, as large as they come, to the first cube of 2^level voxels that holds something. Steps are those of floats:
// this is a view of a structure, rx_trace is the tracer.
#version 460
#include <raxel/world.glsl>
#include <raxel/rivals/march/pyramid.glsl>
#include <raxel/camera.glsl>
#include <raxel/sky.glsl>

layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba16f) uniform writeonly image2D outColor;
layout(r32ui) uniform writeonly uimage2D outLooks;
layout(r32ui) uniform writeonly uimage2D outEmpty;

layout(push_constant) uniform Push {
    mat4 view_to_world;
    ivec3 camera_cell;
    uint level;
    vec3 camera_frac;
    float heat;
    float edges;
    vec2 tan_half_fov;
} push;

const uint TOP = 5u;        // the largest cubes that are asked for
const uint MOST = 2048u;    // steps of a ray

// Dark blue, green, yellow, red.
vec3 heat_color(float x) {
    x = clamp(x, 0.0, 1.0);
    return clamp(vec3(2.0 * x - 0.6, 1.2 - abs(2.4 * x - 1.2), 0.9 - 2.4 * x), 0.0, 1.0);
}

// The world's box: the cube that its tree has room for.
ivec3 box_end() {
    return world.origin + (1 << world.log2_size);
}

// Finds a camera ray's entry into the world's box: the distance and the axis of the side, 3 for a camera inside. False if the ray misses the box.
bool enter(vec3 dir, out float t, out uint axis) {
    vec3 low = vec3(world.origin - push.camera_cell) - push.camera_frac, high = vec3(box_end() - push.camera_cell) - push.camera_frac;
    float leave = RX_FAR;
    t = 0.0;
    axis = 3u;
    for (uint i = 0u; i < 3u; ++i) {
        if (dir[i] == 0.0) {
            if (low[i] > 0.0 || high[i] <= 0.0) return false;
            continue;
        }
        float a = low[i] / dir[i], b = high[i] / dir[i];
        if (min(a, b) > t) {
            t = min(a, b);
            axis = i;
        }
        leave = min(leave, max(a, b));
    }
    return t < leave;
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), size = imageSize(outColor);
    if (any(greaterThanEqual(pixel, size))) return;
    RxRay ray = rx_camera_ray(push.camera_cell, push.camera_frac, push.view_to_world, push.tan_half_fov, pixel, size);
    vec3 sun = rx_sun_direction(215.0, 32.0), color = 0.35 * rx_sky(ray.dir, sun);
    uint looks = 0u, empty = 0u, axis;
    float t;
    bool met = false, inside = enter(ray.dir, t, axis);
    ivec3 cell = clamp(ray.cell + ivec3(floor(ray.frac + t * ray.dir)), world.origin, box_end() - 1);
    for (uint i = 0u; inside && i < MOST; ++i) {
        ++looks;
        if (rx_occupied(cell, push.level)) {
            met = true;
            ivec3 corner = world.origin + (cell - world.origin >> push.level << push.level);
            vec3 place = clamp((vec3(ray.cell - corner) + ray.frac + t * ray.dir) / float(1u << push.level), 0.0, 1.0);
            vec3 beside = min(place, 1.0 - place);
            float side = axis == 3u ? 1.0 : axis == 1u ? 1.0 : axis == 0u ? 0.75 : 0.6;
            if (axis < 3u) beside[axis] = 1.0;
            float edge = min(beside.x, min(beside.y, beside.z)) < push.edges ? 0.45 : 1.0;
            color = side * edge * mix(vec3(0.85, 0.55, 0.25), vec3(0.25, 0.55, 0.85), float(empty) / float(TOP));
            break;
        }
        // The largest empty cube here.
        empty = push.level;
        while (empty < TOP) {
            ++looks;
            if (rx_occupied(cell, empty + 1u)) break;
            ++empty;
        }
        ivec3 low = world.origin + (cell - world.origin >> empty << empty), high = low + (1 << empty);
        vec3 planes = mix(vec3(low - ray.cell), vec3(high - ray.cell), greaterThan(ray.dir, vec3(0.0)));
        vec3 away = vec3(RX_FAR);
        for (uint a = 0u; a < 3u; ++a) if (ray.dir[a] != 0.0) away[a] = (planes[a] - ray.frac[a]) / ray.dir[a];
        axis = away.x <= away.y && away.x <= away.z ? 0u : away.y <= away.z ? 1u : 2u;
        t = max(away[axis], t);
        cell = clamp(ray.cell + ivec3(floor(ray.frac + t * ray.dir)), low, high - 1);
        cell[axis] = ray.dir[axis] > 0.0 ? high[axis] : low[axis] - 1;
        inside = rx_in_world(cell);
    }
    vec3 cost = heat_color(float(looks) / 96.0);
    imageStore(outColor, pixel, vec4(mix(color, cost, push.heat), 1.0));
    imageStore(outLooks, pixel, uvec4(looks));
    imageStore(outEmpty, pixel, uvec4(met ? empty : TOP + 1u));
}
