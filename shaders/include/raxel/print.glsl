// Lets shaders print and assert. `debugPrintfEXT("depth %f at %v2d", depth, pixel)` prints a line for each invocation that reaches it, on every
// device: in the terminal, in the window's panel *Problems*, and to programs. The graph needs no key for it. docs/book/do/mistakes.md has an
// example, and docs/shader-prints.md the details.
#ifndef RAXEL_PRINT_GLSL
#define RAXEL_PRINT_GLSL

#extension GL_EXT_debug_printf : require

/// Reports an error if a condition is false: with the line, the pass, the first invocation, the frame, and the number of invocations. The
/// shader goes on.
#define rx_assert(condition) \
    do { \
        if (!(condition)) debugPrintfEXT("rx_assert"); \
    } while (false)

#endif
