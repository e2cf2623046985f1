// Finds the positions that places on instances had in the last frame. Needs <raxel/place.glsl>.
layout(std430) readonly buffer Poses { uint moves; uint leaps; uint last; uint unused; uvec4 poses[]; };

// From a camera of the last frame to a place on an instance, as it was then, in world space.
vec3 moved_from(ivec3 voxel, uint face, vec2 uv, ivec3 camera_cell, vec3 camera_frac) {
    uint first = 2u * RX_INSTANCE_QUADS * rx_place_instance(voxel);
    uvec4 q[RX_INSTANCE_QUADS];
    for (uint i = 0u; i < RX_INSTANCE_QUADS; ++i) q[i] = poses[first + i];
    RxRay ray = RX_RAY(rx_ray_from_instance(rx_instance_of_quads(q), voxel, face, uv, vec3(0.0)));
    return vec3(ray.cell - camera_cell) + (ray.frac - camera_frac);
}
