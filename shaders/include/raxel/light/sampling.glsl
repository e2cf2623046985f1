// Directions drawn from distributions that light transport asks for. `u` are two random numbers in [0, 1).
#ifndef RAXEL_LIGHT_SAMPLING_GLSL
#define RAXEL_LIGHT_SAMPLING_GLSL

#include "../ray.glsl"

const float RX_PI = 3.14159265358979;

// Two unit vectors across a unit vector, each at right angles to the others (Duff and others, "Building an orthonormal basis,
// revisited", 2017).
void rx_basis(vec3 normal, out vec3 tangent, out vec3 bitangent) {
    float side = normal.z >= 0.0 ? 1.0 : -1.0;
    float a = -1.0 / (side + normal.z), b = normal.x * normal.y * a;
    tangent = vec3(1.0 + side * normal.x * normal.x * a, side * b, -side * normal.x);
    bitangent = vec3(b, side + normal.y * normal.y * a, -normal.y);
}

// A direction out of a face with the density cosine / pi: a point of the disc, raised to the hemisphere (Malley's method).
vec3 rx_cosine_direction(uint face, vec2 u) {
    ivec3 t, b;
    rx_face_tangents(face, t, b);
    float r = sqrt(u.x), a = 2.0 * RX_PI * u.y;
    return r * cos(a) * vec3(t) + r * sin(a) * vec3(b) + sqrt(1.0 - u.x) * rx_normal(face);
}

// A direction inside a cone around a unit vector, even over its solid angle. `height` is 1 - cos(half angle).
vec3 rx_cone_direction(vec3 axis, float height, vec2 u) {
    float h = u.x * height;
    float r = sqrt(h * (2.0 - h)), a = 2.0 * RX_PI * u.y;
    vec3 t, b;
    rx_basis(axis, t, b);
    return r * cos(a) * t + r * sin(a) * b + (1.0 - h) * axis;
}

#endif
