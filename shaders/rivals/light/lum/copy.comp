// Keeps the field for the next frame, so that no probe reads the output of another.
#version 460
layout(local_size_x = 4, local_size_y = 4, local_size_z = 4) in;
layout(PROBES) uniform readonly image3D probes;
layout(PROBES) uniform writeonly image3D outProbes;

void main() {
    ivec3 probe = ivec3(gl_GlobalInvocationID);
    if (all(lessThan(probe, imageSize(outProbes)))) imageStore(outProbes, probe, imageLoad(probes, probe));
}
