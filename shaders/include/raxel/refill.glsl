// Traces many period rays, and keeps all lanes of a subgroup at work. A lane whose ray has ended takes a new one, so no subgroup waits for its
// longest ray. A shader that includes this, behind its `local_size`, defines
//
//     bool rx_next_items(out uint first);                             the first of RX_ITEMS items for this subgroup; false if there are no more
//     bool rx_next_ray(uint item, out RxPeriodRay ray);               the ray of an item; false if it has none
//     void rx_ray_traced(uint item, bool found, RxPeriodHit hit);     takes what it hit
//
// and calls rx_trace_items with all threads of its workgroup. One lane asks for items. If a graph keeps a counter for
// them, each subgroup continues with untaken items, and all work until the end of the dispatch. Neighbouring items
// should be rays that start close to each other.
//
// After Aila and Laine, "Understanding the efficiency of ray traversal on GPUs" (2009), whose persistent threads refill likewise.
#ifndef RAXEL_REFILL_GLSL
#define RAXEL_REFILL_GLSL

// With RX_PLAIN_BALLOTS the older ballots and votes are used, which do not ask which invocations are active and so cost less. A pass with
// `when = "device.ballots"` runs where a shader may define that.
#extension GL_KHR_shader_subgroup_basic : require
#ifdef RX_PLAIN_BALLOTS
#extension GL_ARB_shader_ballot : require
#extension GL_ARB_shader_group_vote : require
#extension GL_ARB_gpu_shader_int64 : require
#else
#extension GL_KHR_shader_subgroup_ballot : require
#extension GL_KHR_shader_subgroup_vote : require
#endif

#include "period.glsl"

#ifdef RX_PLAIN_BALLOTS
#define RX_REFILL_ANY(vote) anyInvocationARB(vote)
#define RX_REFILL_FIRST(value) readFirstInvocationARB(value)
#define RX_REFILL_BALLOT(vote) unpackUint2x32(ballotARB(vote)).x
#define RX_REFILL_COUNT(ballot) uint(bitCount(ballot))
#define RX_REFILL_BEFORE(ballot) uint(bitCount((ballot) & ((1u << gl_SubgroupInvocationID) - 1u)))
#define RX_REFILL_SET uint
#else
#define RX_REFILL_ANY(vote) subgroupAny(vote)
#define RX_REFILL_FIRST(value) subgroupBroadcastFirst(value)
#define RX_REFILL_BALLOT(vote) subgroupBallot(vote)
#define RX_REFILL_COUNT(ballot) subgroupBallotBitCount(ballot)
#define RX_REFILL_BEFORE(ballot) subgroupBallotExclusiveBitCount(ballot)
#define RX_REFILL_SET uvec4
#endif

#ifndef RX_ITEMS
#define RX_ITEMS 256u
#endif

// Defined by the shader. Returns the first of RX_ITEMS items for this subgroup; false if there are no more.
bool rx_next_items(out uint first);

// Defined by the shader. Gives the ray of an item; false if it has none.
bool rx_next_ray(uint item, out RxPeriodRay ray);

// Defined by the shader. Takes what the ray of an item hits.
void rx_ray_traced(uint item, bool found, RxPeriodHit hit);

// Traces the rays of all items. Every thread of the workgroup calls it.
void rx_trace_items() {
    const uint NOTHING = 3u;
    rx_period_prepare(gl_LocalInvocationIndex, gl_WorkGroupSize.x * gl_WorkGroupSize.y * gl_WorkGroupSize.z);
    uint state = NOTHING, item = 0u, next = RX_ITEMS, items = 0u;
    bool more = true;
    for (;;) {
        if (state == RX_PERIOD_HIT || state == RX_PERIOD_GONE) {
            RxPeriodHit hit = RxPeriodHit(ivec3(0), 0u, 0.0, vec2(0.0));
            if (state == RX_PERIOD_HIT) hit = rx_period_hit();
            rx_ray_traced(item, state == RX_PERIOD_HIT, hit);
        }
        RX_REFILL_SET idle = RX_REFILL_BALLOT(state != RX_PERIOD_GOES);
        uint mine = next + RX_REFILL_BEFORE(idle), own = items;
        next += RX_REFILL_COUNT(idle);
        if (next > RX_ITEMS && more) {
            uint first = 0u;
            bool found = false;
            if (gl_SubgroupInvocationID == 0u) found = rx_next_items(first);
            first = RX_REFILL_FIRST(first);
            more = RX_REFILL_ANY(found);
            if (more) {
                items = first;
                next -= RX_ITEMS;
                if (mine >= RX_ITEMS) {
                    mine -= RX_ITEMS;
                    own = items;
                }
            }
        }
        if (state != RX_PERIOD_GOES) {
            state = NOTHING;
            RxPeriodRay ray;
            if (mine < RX_ITEMS && rx_next_ray(own + mine, ray)) {
                item = own + mine;
                state = rx_period_begin(ray) ? RX_PERIOD_GOES : RX_PERIOD_GONE;
            }
        }
        uint busy = RX_REFILL_COUNT(RX_REFILL_BALLOT(state == RX_PERIOD_GOES));
        if (busy == 0u) {
            if (!more && next >= RX_ITEMS && !RX_REFILL_ANY(state == RX_PERIOD_GONE)) break;
            continue;
        }
        // Half of the lanes may idle before it pays to leave the loop; looking at them every other round does.
        uint least = more || next < RX_ITEMS ? gl_SubgroupSize / 2u : 0u;
        do {
            if (state == RX_PERIOD_GOES) state = rx_period_round();
            if (state == RX_PERIOD_GOES) state = rx_period_round();
            busy = RX_REFILL_COUNT(RX_REFILL_BALLOT(state == RX_PERIOD_GOES));
        } while (busy > least);
    }
}

#endif
