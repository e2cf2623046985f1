// Takes light of earlier frames from places on the same plane. Faces of one plane share light, so a pixel may take it from its neighbours. The
// same voxel face would be too strict a test, because voxels are smaller than pixels. The luminance's mean square gives its variance.
#version 460
#include "light/scene.glsl"
#include "light/change.glsl"
#include <raxel/light/reproject.glsl>

layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba32i) uniform readonly iimage2D hits;
layout(rgba32f) uniform readonly image2D places;
layout(rgba32i) uniform readonly iimage2D hitsBefore;
layout(rgba32f) uniform readonly image2D path;
layout(rgba32f) uniform readonly image2D meanBefore;
layout(rg32f) uniform readonly image2D momentsBefore;
layout(rgba32f) uniform writeonly image2D outMean;
layout(rg32f) uniform writeonly image2D outMoments;
layout(push_constant) uniform Push { mat4 world_to_view; ivec3 cell; int history; vec3 frac; } push;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), size = imageSize(outMean);
    if (any(greaterThanEqual(pixel, size))) return;
    ivec4 hit = imageLoad(hits, pixel);
    uint face = hit_face(hit.w), axis = rx_face_axis(face);
    vec3 now = imageLoad(path, pixel).rgb;
    vec4 old = vec4(0.0);
    vec2 old_moments = vec2(0.0);
    if (hit.w >= 0 && face != RX_FACE_INSIDE) {
        vec2 at;
        vec3 way = vec3(frame.camera_cell - push.cell) + (frame.camera_frac - push.frac)
                 + imageLoad(places, pixel).z * pixel_direction(pixel, size);
        if (rx_reproject(way, mat3(push.world_to_view), frame.tan_half_fov, vec2(size), at)) {
            ivec2 base = ivec2(floor(at - 0.5));
            vec2 part = at - 0.5 - vec2(base);
            float weight = 0.0;
            for (int i = 0; i < 4; ++i) {
                ivec2 tap = base + ivec2(i & 1, i >> 1);
                if (any(lessThan(tap, ivec2(0))) || any(greaterThanEqual(tap, size))) continue;
                ivec4 there = imageLoad(hitsBefore, tap);
                if (there.w < 0 || hit_face(there.w) != face || there[axis] != hit[axis]) continue;
                float w = ((i & 1) != 0 ? part.x : 1.0 - part.x) * ((i >> 1) != 0 ? part.y : 1.0 - part.y);
                old += w * imageLoad(meanBefore, tap);
                old_moments += w * imageLoad(momentsBefore, tap).xy;
                weight += w;
            }
            old = weight > 1e-3 ? old / weight : vec4(0.0);
            old_moments = weight > 1e-3 ? old_moments / weight : vec2(0.0);
        }
    }
    float most = max(float(push.history), float(frame.still));
    if (state.changed != 0u) most = min(most, state.cap);
    float n = min(old.w, most) + 1.0, l = dot(now, vec3(0.2126, 0.7152, 0.0722));
    vec3 mean = old.rgb + (now - old.rgb) / n;
    vec2 moments = old_moments + (vec2(l, l * l) - old_moments) / n;
    imageStore(outMean, pixel, vec4(mean, n));
    imageStore(outMoments, pixel, vec4(moments, 0.0, 0.0));
}
