// Density of the water in cubes of half a voxel, in parts of that at rest: the visible water.
#version 460
#include "water.glsl"
#include "neighbours.glsl"

layout(local_size_x = 4, local_size_y = 4, local_size_z = 4) in;
layout(std430) readonly buffer Starts { uint starts[]; };
layout(std430) readonly buffer Particles { Particle sorted[]; };   // still in the order of cells
layout(r16f) uniform writeonly image3D outField;

void main() {
    ivec3 texel = ivec3(gl_GlobalInvocationID);
    if (any(greaterThanEqual(texel, imageSize(outField)))) return;
    vec3 at = (vec3(texel) + 0.5) * 0.5, unused;
    float sum = 0.0;
    if (!solid(ivec3(floor(at)))) {
        FOR_NEIGHBOURS(grid_index(cell_at(at)), {
            vec3 from = at - sorted[j].at;
            sum += kernel(dot(from, from));
        })
        sum = sum / REST;
        // Water stands at a wall as it stands in the open.
        if (sum > 0.0) sum += density_of_walls(at, unused) * min(sum, 1.0);
    }
    imageStore(outField, texel, vec4(sum));
}
