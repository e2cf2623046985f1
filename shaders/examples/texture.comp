// The first voxel along each pixel's ray, with a picture on its face. The mip follows the size of the pixel on the face.
#version 460
#include <raxel/world.glsl>
#include <raxel/camera.glsl>
#include <raxel/shade.glsl>

layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba16f) uniform writeonly image2D outColor;
uniform sampler2D tiles;  // linear light

layout(push_constant) uniform Push {
    mat4 view_to_world;
    ivec3 camera_cell;
    float tile;  // voxels
    vec3 camera_frac;
    vec2 tan_half_fov;
} push;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    ivec2 size = imageSize(outColor);
    if (any(greaterThanEqual(pixel, size))) return;

    vec3 sun = rx_sun_direction(215.0, 40.0);
    RxRay ray = rx_camera_ray(push.camera_cell, push.camera_frac, push.view_to_world, push.tan_half_fov, pixel, size);
    RxHit hit;
    vec3 color = rx_sky(ray.dir, sun);
    if (rx_trace(ray, hit) && hit.face != RX_FACE_INSIDE) {
        vec3 normal = rx_normal(hit.face);
        // Voxels count along the face: the picture goes on over their edges. A remainder keeps the numbers small far from the origin.
        uint axis = rx_face_axis(hit.face);
        ivec2 along = axis == 0u ? hit.voxel.yz : axis == 1u ? hit.voxel.xz : hit.voxel.xy;
        vec2 uv = (vec2(along & 1023) + hit.uv) / push.tile;
        // Voxels that the pixel covers on the face, longer where the face is seen from the side.
        float covered = hit.t * 2.0 * push.tan_half_fov.y / float(size.y) / max(abs(dot(ray.dir, normal)), 0.1);
        float mip = log2(max(covered / push.tile * float(textureSize(tiles, 0).x), 1.0));
        color = textureLod(tiles, uv, mip).rgb * (0.35 + 0.65 * max(dot(normal, sun), 0.0));
        color = mix(color, color * 4.0 * rx_material_properties(hit.material).albedo, 0.5);
    }
    imageStore(outColor, pixel, vec4(rx_tone_curve(color), 1.0));
}
