// The world with the water in it. A ray walks through cubes of half a voxel, and finds water where their density passes one half. Water mirrors the sky
// and the world by Fresnel's law, and shows the things behind it, less the loss on the way. With MICRO, the cubes are micro-voxels, a quarter of a voxel
// wide, and the exact tracer finds where rays of the camera meet them.
#version 460
#include <raxel/world.glsl>
#include <raxel/shade.glsl>
#include <raxel/camera.glsl>
#include <raxel/light/bsdf.glsl>
#ifdef MICRO
#include <raxel/micro.glsl>
#endif

layout(local_size_x = 8, local_size_y = 8) in;
uniform sampler3D field;
#ifdef MICRO
uniform usampler3D micro;
#endif
layout(rgba16f) uniform writeonly image2D outColor;
layout(push_constant) uniform Push {
    mat4 view_to_world;
    ivec3 camera_cell;
    bool smoothed;         // normals from the slope of the density, else those of the cubes
    vec3 camera_frac;
    float exposure;
    vec2 tan_half_fov;
    ivec3 corner;
} push;

const vec3 LOSS = vec3(0.42, 0.13, 0.08);   // per voxel
const float SURFACE = 0.5;

#ifdef MICRO
const float CUBES = 4.0;   // along a voxel

ivec3 cubes() {
    return 4 * textureSize(micro, 0);
}

bool wet(ivec3 cube) {
    return rx_micro_has(micro, cube);
}
#else
const float CUBES = 2.0;

ivec3 cubes() {
    return textureSize(field, 0);
}

bool wet(ivec3 cube) {
    return texelFetch(field, cube, 0).x > SURFACE;
}
#endif

// Finds the first cube with water from `from` on, the last exit of the ray from water, and the total length in water.
struct Way {
    bool met;
    float t;         // where water begins
    vec3 normal;
    float through;   // voxels of water until `most`
};

Way walk(vec3 from, vec3 dir, float most) {
    Way way = Way(false, 0.0, vec3(0.0), 0.0);
    ivec3 size = cubes();
    // In cubes; the ray is cut to the box.
    vec3 o = CUBES * from, inv = 1.0 / mix(dir, vec3(1e-9), lessThan(abs(dir), vec3(1e-9)));
    vec3 a = -o * inv, b = (vec3(size) - o) * inv, low = min(a, b), high = max(a, b);
    float t = max(max(low.x, low.y), max(low.z, 0.0)), end = min(min(high.x, high.y), min(high.z, CUBES * most));
    if (t >= end) return way;
    vec3 at = clamp(o + t * dir, vec3(0.0), vec3(size) - 1e-3);
    ivec3 cell = ivec3(floor(at)), step_way = ivec3(sign(inv));
    vec3 next = (vec3(cell) + step(0.0, inv) - o) * inv;
    int entered = low.x >= low.y && low.x >= low.z ? 0 : low.y >= low.z ? 1 : 2;
    for (int i = 0; i < 800 && t < end; ++i) {
        float leaves = min(min(next.x, next.y), min(next.z, end));
        if (wet(cell)) {
            if (!way.met) {
                way.met = true;
                way.t = t / CUBES;
                way.normal[entered] = -float(step_way[entered]);
            }
            way.through += max(leaves - t, 0.0) / CUBES;
        }
        entered = next.x <= next.y && next.x <= next.z ? 0 : next.y <= next.z ? 1 : 2;
        t = next[entered];
        next[entered] += abs(inv[entered]);
        cell[entered] += step_way[entered];
        if (any(lessThan(cell, ivec3(0))) || any(greaterThanEqual(cell, size))) break;
    }
    return way;
}

// Light of the world along a ray: one loop round one tracer.
vec3 world_light(RxRay ray, vec3 sun, out float distance) {
    vec3 color = vec3(0.0), waiting = vec3(0.0);
    distance = RX_FAR;
    for (int turn = 0; turn < 2; ++turn) {
        RxHit hit;
        bool found = rx_trace(ray, hit);
        if (turn == 1) {
            if (!found) color += waiting;
            break;
        }
        if (!found) return rx_sky(ray.dir, sun);
        distance = hit.t;
        if (hit.face == RX_FACE_INSIDE) return vec3(0.0);
        vec3 normal = rx_normal(hit.face);
        RxMaterial material = rx_material_properties(hit.material);
        vec3 albedo = material.albedo * rx_grain(hit.voxel);
        color = albedo * (material.emission + 0.6 * rx_openness(hit) * rx_ambient(normal, sun));
        waiting = albedo * 2.3 * max(dot(normal, sun), 0.0) * rx_sun_color(sun);
        // Water takes some of the sun from the things below it.
        vec3 place = vec3(hit.voxel - push.corner) + rx_ray_from_face(hit.voxel, hit.face, hit.uv, sun).frac + vec3(rx_face_step(hit.face));
        waiting *= exp(-LOSS * walk(place, sun, 200.0).through);
        if (waiting.y <= 0.0) break;
        ray = rx_ray_from_face(hit.voxel, hit.face, hit.uv, sun);
    }
    return color;
}

vec3 slope(vec3 at) {
    vec3 size = vec3(textureSize(field, 0)), uvw = 2.0 * at / size, d = 1.5 / size;
    vec3 g = vec3(textureLod(field, uvw + vec3(d.x, 0.0, 0.0), 0.0).x - textureLod(field, uvw - vec3(d.x, 0.0, 0.0), 0.0).x,
                  textureLod(field, uvw + vec3(0.0, d.y, 0.0), 0.0).x - textureLod(field, uvw - vec3(0.0, d.y, 0.0), 0.0).x,
                  textureLod(field, uvw + vec3(0.0, 0.0, d.z), 0.0).x - textureLod(field, uvw - vec3(0.0, 0.0, d.z), 0.0).x);
    return g;
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), size = imageSize(outColor);
    if (any(greaterThanEqual(pixel, size))) return;
    vec3 sun = rx_sun_direction(215.0, 42.0);
    vec3 dir = rx_camera_direction(push.view_to_world, push.tan_half_fov, vec2(pixel) + 0.5, vec2(size));
    vec3 from = vec3(push.camera_cell - push.corner) + push.camera_frac;
    float distance, unused;
    vec3 color = world_light(rx_ray(push.camera_cell, push.camera_frac, dir), sun, distance);
    Way way = walk(from, dir, distance);
#ifdef MICRO
    RxHit cube;
    way.met = rx_trace_micro(micro, push.corner, rx_micro_ray(rx_ray(push.camera_cell, push.camera_frac, dir)), cube) && 0.25 * cube.t < distance;
    way.t = 0.25 * cube.t;
    if (cube.face != RX_FACE_INSIDE) way.normal = rx_normal(cube.face);
#endif
    if (way.met) {
        vec3 at = from + way.t * dir, normal = way.normal, g = slope(at);
        if (push.smoothed && dot(g, g) > 1e-6) normal = normalize(-g);
        if (dot(normal, dir) > 0.0) normal = way.normal;
        float mirrored = rx_fresnel_dielectric(clamp(-dot(dir, normal), 0.02, 1.0), 1.333);
        vec3 turned = reflect(dir, normal);
        // The mirrored ray begins just outside of the water, in the world's own cell.
        vec3 outside = at + 0.02 * normal;
        ivec3 cell = ivec3(floor(outside));
        vec3 sky = rx_material(push.corner + cell) == 0u ? world_light(rx_ray(push.corner + cell, outside - vec3(cell), turned), sun, unused) : vec3(0.0);
        sky += 4.0 * pow(max(dot(turned, sun), 0.0), 400.0) * rx_sun_color(sun);
        vec3 through = exp(-LOSS * way.through);
        color = color * through + vec3(0.05, 0.20, 0.25) * (1.0 - through);
        color = mix(color, sky, mirrored);
    }
    imageStore(outColor, pixel, vec4(rx_tone_curve(push.exposure * color), 1.0));
}
