use crate::code::declare;

declare! {
    /// An `#include` names a file that is nowhere.
    INCLUDE_NOT_FOUND = "RX0201";
    /// An `#include` is absolute or leaves the project root.
    INCLUDE_OUTSIDE = "RX0202";
    /// A file includes itself, directly or through others.
    INCLUDE_CYCLE = "RX0203";
    /// Includes are nested too deep, or a text, a macro or a statement is too large.
    TOO_MUCH = "RX0204";
    /// The shader does not compile.
    COMPILE = "RX0210";
    /// The shader compiles, but the compiler warns.
    WARNING = "RX0211";
    /// A GLSL shader has no `#version`.
    NO_VERSION = "RX0212";
    /// The shader has no such entry point.
    NO_ENTRY = "RX0213";
    /// The shader is empty.
    EMPTY = "RX0214";
    /// A preprocessor definition that no shader language can take.
    BAD_DEFINE = "RX0215";
    /// A text that the shader compiler cannot read.
    BAD_TEXT = "RX0216";
    /// A call whose result GLSL and SPIR-V leave undefined.
    UNDEFINED = "RX0217";
    /// A call of `debugPrintfEXT` whose text and values do not fit, or whose values cannot be printed.
    UNPRINTABLE = "RX0218";
    /// A SPIR-V module is malformed.
    BAD_SPIRV = "RX0220";
    /// A SPIR-V module is of a version or kind that raxel does not run.
    UNSUPPORTED_SPIRV = "RX0221";
    /// The interface of a module cannot be read.
    REFLECTION = "RX0222";
}
