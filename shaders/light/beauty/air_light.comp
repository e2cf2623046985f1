// Whether the sun reaches the air: a ray for each slice of the view (air_slices.glsl), at another depth in each frame. A thread each, because
// rays through the columns one after the other leave most of a GPU without work.
// With PANES, rays go through clear bodies of at most so many voxels, and a second one asks how much of the sky is seen.
#version 460
#include <raxel/world.glsl>
#include "../scene.glsl"
#include "air_slices.glsl"
#ifdef PANES
#include <raxel/light/body.glsl>
layout(rgba16f) uniform writeonly image3D outSky;
#endif

layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba16f) uniform writeonly image3D outSun;   // share of sunlight that comes through

void main() {
    ivec3 slice = ivec3(gl_GlobalInvocationID), size = imageSize(outSun);
    if (any(greaterThanEqual(slice, size))) return;
    vec3 sun = frame_sun();
    float t = slice_place(slice, size);
    vec3 lit = vec3(1.0), above = vec3(1.0);
    if (t < 600.0) {
        vec3 at = frame.camera_frac + t * rx_camera_direction(frame.view_to_world, frame.tan_half_fov, vec2(slice.xy) + 0.5, vec2(size.xy));
        ivec3 cell = ivec3(floor(at));
        RxRay ray = rx_ray(frame.camera_cell + cell, at - vec3(cell), sun);
        RxHit block;
        bool blocked = sun_irradiance(sun) != vec3(0.0) && rx_trace(ray, block);
#ifdef PANES
        for (int pane = 0; pane < 2 && blocked && rx_pass_body(block, PANES, ray, lit); ++pane) blocked = rx_trace(ray, block);
#endif
        if (blocked) lit = vec3(0.0);
#ifdef PANES
        // Indoors, little of the sky reaches the mist: one ray to anywhere above says how much.
        uint state = rx_hash(rx_hash(slice_seed(slice)) ^ frame.index);
        vec3 up = rx_random_direction(state);
        up.y = abs(up.y) + 1e-3;
        vec3 open = vec3(1.0);
        ray = rx_ray(frame.camera_cell + cell, at - vec3(cell), up);
        blocked = rx_trace(ray, block);
        for (int pane = 0; pane < 2 && blocked && rx_pass_body(block, PANES, ray, open); ++pane) blocked = rx_trace(ray, block);
        above = blocked ? vec3(0.0) : open;
#endif
    }
    imageStore(outSun, slice, vec4(lit, 1.0));
#ifdef PANES
    imageStore(outSky, slice, vec4(above, 1.0));
#endif
}
