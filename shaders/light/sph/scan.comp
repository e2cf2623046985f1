// Sums the counts of the cells before each cell: the index of its first particle, in the order of cells. One workgroup.
#version 460

layout(local_size_x = 256) in;
layout(std430) readonly buffer Counts { uint counts[]; };
layout(std430) writeonly buffer Starts { uint starts[]; };   // one more than there are counts

shared uint sums[256];

void main() {
    uint i = gl_LocalInvocationIndex, cells = counts.length(), each = (cells + 255u) / 256u;
    uint from = min(i * each, cells), to = min(from + each, cells), sum = 0u;
    for (uint c = from; c < to; ++c) sum += counts[c];
    sums[i] = sum;
    for (uint s = 1u; s < 256u; s <<= 1) {
        barrier();
        uint before = i >= s ? sums[i - s] : 0u;
        barrier();
        sums[i] += before;
    }
    uint at = sums[i] - sum;
    for (uint c = from; c < to; ++c) {
        starts[c] = at;
        at += counts[c];
    }
    if (to == cells && (from < to || i == 0u)) starts[cells] = at;
}
