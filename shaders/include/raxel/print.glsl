// What shaders say while they run: text with values, and assertions. `debugPrintfEXT("depth %f at %v2d", depth, pixel)` prints a line of each
// invocation that reaches it, on every device: in the terminal, in the window's panel *Problems*, to programs. The graph needs no word of
// it. docs/book/do/mistakes.md has an example, and docs/shader-prints.md the details.
#ifndef RAXEL_PRINT_GLSL
#define RAXEL_PRINT_GLSL

#extension GL_EXT_debug_printf : require

/// A statement that says so where a condition does not hold: an error with the place, the pass, the invocation and the frame, and how many
/// invocations there were. The shader goes on.
#define rx_assert(condition) \
    do { \
        if (!(condition)) debugPrintfEXT("rx_assert"); \
    } while (false)

#endif
