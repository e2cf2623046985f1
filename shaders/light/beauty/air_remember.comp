// Keeps this frame's means of the air for the next frame.
#version 460
layout(local_size_x = 8, local_size_y = 8) in;
uniform sampler3D sunBySlice;
uniform sampler3D skyBySlice;
uniform sampler3D lampsBySlice;
layout(rgba32f) uniform writeonly image3D outSun;
layout(rgba32f) uniform writeonly image3D outSky;
layout(rgba32f) uniform writeonly image3D outLamps;

void main() {
    ivec3 slice = ivec3(gl_GlobalInvocationID);
    if (any(greaterThanEqual(slice, imageSize(outSun)))) return;
    imageStore(outSun, slice, texelFetch(sunBySlice, slice, 0));
    imageStore(outSky, slice, texelFetch(skyBySlice, slice, 0));
    imageStore(outLamps, slice, texelFetch(lampsBySlice, slice, 0));
}
