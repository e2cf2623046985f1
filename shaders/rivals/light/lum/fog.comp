// Fog between the eye and the first hit: 16 steps through the radiance field, after mirror images and before the tone map.
#version 460
#include <raxel/ray.glsl>
#include "light/scene.glsl"
#include "field.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba32i) uniform readonly iimage2D hits;
layout(rgba32f) uniform readonly image2D places;
uniform sampler3D probes;
layout(rgba32f) uniform image2D radiance;
layout(push_constant) uniform Push { float thickness; } push;

const int STEPS = 16;
const float CLEAR = 6.0;   // optical depth behind which nothing is seen

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), size = imageSize(radiance);
    if (any(greaterThanEqual(pixel, size)) || push.thickness <= 0.0) return;
    vec3 dir = pixel_direction(pixel, size);
    float far = CLEAR / push.thickness;
    bool sky = imageLoad(hits, pixel).w < 0;
    if (!sky) far = min(far, imageLoad(places, pixel).z);
    // The fog ends with the field.
    vec3 from = vec3(frame.camera_cell - grid.world_min) + frame.camera_frac, size_of_field = vec3(16 * textureSize(probes, 0));
    vec3 inverse = 1.0 / (dir + mix(vec3(0.0), vec3(1e-12), equal(dir, vec3(0.0)))), a = -from * inverse, b = (size_of_field - from) * inverse;
    vec3 low = min(a, b), high = max(a, b);
    float near = max(max(low.x, max(low.y, low.z)), 0.0);
    far = min(far, min(high.x, min(high.y, high.z)));
    if (far <= near) return;
    float step = (far - near) / float(STEPS), through = exp(-push.thickness * step), clear = 1.0;
    // Half a step at random hides the layers.
    uint seed = scene_seed(uint(pixel.x) + rx_hash(uint(pixel.y) + 57u));
    float start = rx_random(seed);
    vec3 light = vec3(0.0);
    for (int i = 0; i < STEPS; ++i) {
        // The field has no directions, so fog scatters the same to all sides.
        vec3 at = from + (near + (float(i) + start) * step) * dir;
        light += clear * (1.0 - through) * field_in_air(probes, at);
        clear *= through;
    }
    imageStore(radiance, pixel, vec4(light + clear * imageLoad(radiance, pixel).rgb, 1.0));
}
