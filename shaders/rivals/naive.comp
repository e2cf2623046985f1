// The march of the first version of raxel, kept as the baseline: steps of fixed length, a linear search through the chunks at each new chunk,
// normals by central differences. It steps over corners, needs a thousand samples for 50 voxels, and its normals are zero where both sides are
// solid. primary.comp shows how it is done today. Needs the layout `chunks`.
#version 460
#include <raxel/world.glsl>

layout(local_size_x = 16, local_size_y = 16) in;
layout(rgba16f) uniform writeonly image2D outColor;

layout(push_constant) uniform Push {
    mat4 view;          // world to view, rotation only
    ivec3 camera_cell;
    float fov;          // vertical, radians
    vec3 camera_frac;
    float step_length;  // voxels
    float max_distance;
    int max_steps;
} push;

const float EPSILON = 0.01;

struct Marched {
    vec3 position;  // relative to the camera's cell
    vec3 normal;
    uint material;
    bool hit;
};

float solid_at(vec3 position) {
    return rx_material(push.camera_cell + ivec3(floor(position))) != 0u ? 1.0 : 0.0;
}

// Points out of the solid: the negative gradient of "how solid".
vec3 estimate_normal(vec3 p) {
    vec2 e = vec2(EPSILON, 0.0);
    vec3 gradient = vec3(solid_at(p + e.xyy) - solid_at(p - e.xyy), solid_at(p + e.yxy) - solid_at(p - e.yxy),
                         solid_at(p + e.yyx) - solid_at(p - e.yyx));
    return gradient == vec3(0.0) ? vec3(0.0) : -normalize(gradient);
}

// The distance at which the ray leaves the world's bounds: there is nothing beyond.
float bounds_end(vec3 origin, vec3 dir) {
    vec3 low = vec3(world.bounds_min - push.camera_cell), high = vec3(world.bounds_last + 1 - push.camera_cell);
    vec3 t = (mix(low, high, greaterThan(dir, vec3(0.0))) - origin) / mix(dir, vec3(1.0), equal(dir, vec3(0.0)));
    t = mix(t, vec3(push.max_distance), equal(dir, vec3(0.0)));
    return min(t.x, min(t.y, t.z));
}

ivec3 cell_at(vec3 position) {
    return push.camera_cell + ivec3(floor(position));
}

Marched march(vec3 origin, vec3 dir) {
    float end = min(push.max_distance, bounds_end(origin, dir));
    float t = 0.0;
    int samples = 0;
    ivec3 cell = cell_at(origin);
    uint material = 0u;
    while (material == 0u && samples < push.max_steps && t <= end) {
        // The chunk that holds the sample is looked for once; then all samples in it are taken.
        ivec3 chunk = cell >> 5;
        uint voxels = rx_find_chunk(chunk);
        while (samples < push.max_steps && t <= end && cell >> 5 == chunk) {
            if (voxels != RX_NO_CHUNK) material = rx_chunk_voxel(voxels, cell);
            if (material != 0u) break;
            t += push.step_length;
            ++samples;
            cell = cell_at(origin + t * dir);
        }
    }
    vec3 position = origin + t * dir;
    return Marched(position, material != 0u ? estimate_normal(position) : vec3(0.0), material, material != 0u);
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    ivec2 size = imageSize(outColor);
    if (any(greaterThanEqual(pixel, size))) return;

    vec2 ndc = (vec2(pixel) + 0.5) / vec2(size) * 2.0 - 1.0;
    float tan_fov = tan(push.fov * 0.5);
    vec3 view_dir = vec3(ndc.x * tan_fov * float(size.x) / float(size.y), -ndc.y * tan_fov, -1.0);
    vec3 dir = normalize(transpose(mat3(push.view)) * view_dir);

    Marched result = march(push.camera_frac, dir);
    vec3 color = vec3(0.0);
    if (result.hit) {
        vec3 light = normalize(vec3(1.0, 1.0, -1.0));
        float diffuse = max(dot(result.normal, light), 0.0);
        color = rx_material_properties(result.material).albedo * (0.15 + 0.85 * diffuse);
    }
    imageStore(outColor, pixel, vec4(color, 1.0));
}
