// Makes the arguments of a dispatch with one thread for each element of a queue: as many workgroups of the shader's own size as
// cover the count, in rows of one length, because devices need not take more than 65,535 along an axis.
#version 460

layout(local_size_x = 1) in;

/// The workgroup of the pass that the arguments are for.
layout(constant_id = 0) const uint WIDTH = 1;
layout(constant_id = 1) const uint HEIGHT = 1;
layout(constant_id = 2) const uint DEPTH = 1;

layout(push_constant) uniform Push {
    uint word;  // index of the count
};

layout(std430) readonly buffer Queue { uint words[]; } queue;
layout(std430) writeonly buffer Arguments { uint groups[4]; } arguments;

const uint LONGEST = 65535u;

/// ⌈a / b⌉; the sum a + b − 1 could be too large.
uint divided(uint a, uint b) {
    return a / b + uint(a % b != 0u);
}

void main() {
    uint count = queue.words[word];
    uint groups = divided(count, max(WIDTH * HEIGHT * DEPTH, 1u));
    // Without threads there are no rows; with groups of one thread 2^32 of them need three rows more than there can be.
    uint rows = clamp(divided(groups, LONGEST), 1u, LONGEST);
    arguments.groups[0] = min(divided(groups, rows), LONGEST);
    arguments.groups[1] = rows;
    arguments.groups[2] = 1u;
    arguments.groups[3] = 0u;
}
