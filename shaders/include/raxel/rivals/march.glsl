// Ways to find the first hit. A shader that includes this after <raxel/world.glsl> calls `rx_march`; its pass chooses by a define:
//
//     (none)                            rx_trace, the exact tracer of the layout
//     RX_MARCH_FIXED = "1"              steps of fixed length
//     RX_MARCH_ROLLBACK = "1"           the same, with jumps over empty blocks and a step back when it has hit
//     RX_MARCH_DDA = "1"                voxel by voxel
//     RX_MARCH_STACKLESS = "1"          level by level of a pyramid, each level begun anew from the place on the ray
//     RX_MARCH_STACK = "1"              the same, each level kept on a stack
//     RX_MARCH_RAYMASK = "1"            rx_trace with a table of masks that rules out whole 4^3 blocks (in internal/trace.glsl)
//
// They are the methods of other renderers, kept to be measured: most are inexact, each as its file describes. See docs/rivals/marchers.md.
#ifndef RAXEL_MARCH_GLSL
#define RAXEL_MARCH_GLSL

#if defined(RX_MARCH_FIXED)
#include "march/fixed.glsl"
#elif defined(RX_MARCH_ROLLBACK)
#include "march/rollback.glsl"
#elif defined(RX_MARCH_DDA)
#include "march/dda.glsl"
#elif defined(RX_MARCH_STACKLESS)
#include "march/stackless.glsl"
#elif defined(RX_MARCH_STACK)
#include "march/stack.glsl"
#else
// First solid voxel along a ray, by the marcher that a define chooses; without one, by rx_trace.
bool rx_march(RxRay ray, out RxHit hit) {
    return rx_trace(ray, hit);
}
#endif

#endif
