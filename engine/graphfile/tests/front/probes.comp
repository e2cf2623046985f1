#version 460
layout(local_size_x = 4, local_size_y = 4, local_size_z = 4) in;
layout(rgba8) uniform image2DArray cascades;
uniform sampler2D mask;
layout(rgba16f) uniform image3D irradiance;
layout(std430) buffer Counters {
    uint total;
    uint each[15];
} counters;

void main() {
    ivec3 cell = ivec3(gl_GlobalInvocationID);
    vec4 light = imageLoad(cascades, cell) * texelFetch(mask, cell.xy, 0);
    imageStore(cascades, cell, light);
    imageStore(irradiance, cell, light + imageLoad(irradiance, cell));
    atomicAdd(counters.total, counters.each[0]);
}
