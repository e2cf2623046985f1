// Skylight on each of the six faces, which sees half of the sky: irradiance / pi, the mean of 4,096 directions drawn by their cosine. A workgroup
// for each face.
#version 460
#include <raxel/sky.glsl>
#include <raxel/light/environment.glsl>
#include <raxel/light/sobol.glsl>
#include "sky.glsl"

layout(local_size_x = 64) in;
layout(std430) writeonly buffer Ambient { vec4 ambient[6]; };
layout(push_constant) uniform Push { float sun_azimuth; float sun_elevation; } push;

shared vec3 sums[64];

void main() {
    uint face = gl_WorkGroupID.x, i = gl_LocalInvocationIndex;
    vec3 sun = rx_sun_direction(push.sun_azimuth, push.sun_elevation), sum = vec3(0.0);
    for (uint k = 0u; k < 64u; ++k) sum += sky_from(rx_cosine_direction(face, rx_sobol(64u * i + k, 0u, face)), sun);
    sums[i] = sum;
    for (uint s = 32u; s > 0u; s >>= 1) {
        barrier();
        if (i < s) sums[i] += sums[i + s];
    }
    if (i == 0u) ambient[face] = vec4(sums[0] / 4096.0, 1.0);
}
