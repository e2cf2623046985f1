// Adds one sample a pixel to a sum: balls on a chessboard through a thin lens, the pixel and the lens sampled at random.
#version 460
layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba32f) uniform image2D sum;
layout(push_constant) uniform Push {
    mat4 view_to_world;
    vec2 tan_half_fov;
    float aperture;   // radius of the lens; the eye is 1.5 above the board
    uint still;       // frames that nothing has changed
};

const float FOCUS = 8.0;   // distance that is sharp
const vec3 SUN = normalize(vec3(0.5, 0.7, 0.4));

// PCG (Jarzynski and Olano, "Hash Functions for GPU Rendering", 2020).
uvec4 pcg4d(uvec4 v) {
    v = v * 1664525u + 1013904223u;
    v += v.yzxy * v.wxyz;
    v ^= v >> 16u;
    v += v.yzxy * v.wxyz;
    return v;
}

// Distance to the ball nearest along the ray, or −1. Balls of radius 0.8 stand on every fourth square of the board.
float ball(vec3 from, vec3 along, out vec3 normal) {
    float nearest = -1.0;
    for (int i = 0; i < 25; ++i) {
        vec3 center = vec3(float(i % 5 - 2) * 4.0, 0.8, float(i / 5 - 2) * 4.0);
        vec3 apart = from - center;
        float b = dot(apart, along);
        float root = b * b - dot(apart, apart) + 0.64;
        if (root < 0.0) continue;
        float t = -b - sqrt(root);
        if (t > 0.001 && (nearest < 0.0 || t < nearest)) {
            nearest = t;
            normal = normalize(from + t * along - center);
        }
    }
    return nearest;
}

vec3 radiance(vec3 from, vec3 along) {
    vec3 normal, unused;
    float t = ball(from, along, normal);
    float board = along.y < 0.0 ? -from.y / along.y : -1.0;
    vec3 albedo = vec3(0.8, 0.35, 0.2);
    if (board > 0.0 && (t < 0.0 || board < t)) {
        t = board;
        normal = vec3(0.0, 1.0, 0.0);
        vec3 at = from + t * along;
        albedo = vec3(mod(floor(at.x) + floor(at.z), 2.0) < 0.5 ? 0.75 : 0.15);
    }
    vec3 sky = mix(vec3(0.75, 0.82, 0.9), vec3(0.25, 0.45, 0.8), clamp(along.y, 0.0, 1.0));
    if (t < 0.0) return sky;
    bool lit = ball(from + t * along + 0.001 * normal, SUN, unused) < 0.0;
    vec3 light = vec3(0.25, 0.3, 0.4) + (lit ? vec3(1.0, 0.95, 0.85) * max(dot(normal, SUN), 0.0) : vec3(0.0));
    return mix(albedo * light, sky, 1.0 - exp(-0.01 * t));
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    ivec2 size = imageSize(sum);
    if (any(greaterThanEqual(pixel, size))) return;
    vec4 random = vec4(pcg4d(uvec4(pixel, still, 7u))) / 4294967296.0;
    vec2 plane = ((vec2(pixel) + random.xy) / vec2(size) * 2.0 - 1.0) * vec2(1.0, -1.0) * tan_half_fov;
    vec2 lens = aperture * sqrt(random.z) * vec2(cos(6.2831853 * random.w), sin(6.2831853 * random.w));
    vec3 along = normalize(vec3(plane, -1.0) * FOCUS - vec3(lens, 0.0));
    vec3 color = radiance(vec3(0.0, 1.5, 12.0) + mat3(view_to_world) * vec3(lens, 0.0), mat3(view_to_world) * along);
    vec4 before = still == 0u ? vec4(0.0) : imageLoad(sum, pixel);
    imageStore(sum, pixel, before + vec4(color, 1.0));
}
