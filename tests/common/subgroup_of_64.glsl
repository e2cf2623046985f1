// A subgroup of 64 on a device that has smaller ones: every vote, ballot and read goes through shared memory. The workgroup is the subgroup, so it has
// at most 64 invocations, and all of them must come to each operation. Include it before <raxel/packet.glsl>, <raxel/parallel.glsl> or
// <raxel/refill.glsl>, whose own text then runs as on a device with subgroups of 64.
#extension GL_ARB_gpu_shader_int64 : require

shared uint wide_votes[2];
shared uint wide_word;

// Invocations that are not there have no bit.
uvec2 wide_ballot(bool vote) {
    barrier();
    if (gl_LocalInvocationIndex == 0u) wide_votes[0] = wide_votes[1] = 0u;
    barrier();
    if (vote) atomicOr(wide_votes[(gl_LocalInvocationIndex >> 5) & 1u], 1u << (gl_LocalInvocationIndex & 31u));
    barrier();
    return uvec2(wide_votes[0], wide_votes[1]);
}

uint wide_read(uint value, uint lane) {
    barrier();
    if (gl_LocalInvocationIndex == lane) wide_word = value;
    barrier();
    return wide_word;
}

uint wide_count(uvec4 ballot) {
    return uint(bitCount(ballot.x) + bitCount(ballot.y));
}

uint wide_count_before(uvec4 ballot) {
    uint lane = gl_LocalInvocationIndex, below = (1u << (lane & 31u)) - 1u;
    return lane < 32u ? uint(bitCount(ballot.x & below)) : uint(bitCount(ballot.x) + bitCount(ballot.y & below));
}

#define gl_SubgroupSize 64u
#define gl_NumSubgroups 1u
#define gl_SubgroupInvocationID gl_LocalInvocationIndex
#define ballotARB(vote) packUint2x32(wide_ballot(vote))
#define anyInvocationARB(vote) (wide_ballot(vote) != uvec2(0u))
#define allInvocationsARB(vote) (wide_ballot(!(vote)) == uvec2(0u))
#define readInvocationARB(value, lane) wide_read(value, lane)
#define subgroupBallot(vote) uvec4(wide_ballot(vote), 0u, 0u)
#define subgroupBallotBitCount(ballot) wide_count(ballot)
#define subgroupBallotExclusiveBitCount(ballot) wide_count_before(ballot)
#define subgroupAny(vote) (wide_ballot(vote) != uvec2(0u))
#define subgroupBroadcastFirst(value) wide_read(value, 0u)
