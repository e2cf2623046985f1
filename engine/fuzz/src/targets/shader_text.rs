//! Shaders as texts: their tokens, their includes, and the diagnostics of the compiler's messages about them. The compiler itself is not
//! called.

use raxel_diagnostics::MemoryFiles;

use crate::bounds::Bounds;
use crate::{Mutation, Target, check, projects};

pub(crate) const TARGET: Target = Target {
    name: "shader_text",
    run,
    // The files of the library are long.
    bounds: Bounds { bytes: 128 << 20, ..Bounds::PARSER },
    mutation: Mutation::Words(&[
        "#include \"part.glsl\"\n",
        "#include <part.glsl>\n",
        "#include \"main.comp\"\n",
        "#include <raxel/thread.glsl>\n",
        "#include \"../../a\"\n",
        "#pragma once\n",
        "#ifndef A\n#define A\n",
        "#endif\n",
        "#define A A A\n",
        "#define B A(A, A)\n",
        "#version 460\n",
        "#line 7 \"x\"\n",
        "#error x\n",
        "//",
        "/*",
        "*/",
        "\\\n",
        "\"",
        "'",
        "struct S { int a; };",
        "struct T { S a, b[2]; };",
        "(",
        ")",
        "{",
        "}",
        "[",
        "[[",
        "]",
        "numthreads(8, 8)",
        "main(uint3)",
        ";",
        ",",
        ".5",
        "1e+9",
        "a.b",
        "é",
        "漢",
        "\r\n",
        "buffer_reference",
        "smoothstep(1.0, 0.0, x)",
        "#file output\n",
        "shaders/main.comp:3: error: 'a' : undeclared identifier\n",
        "shaders/main.comp:99999999999: warning: '' : x\n",
        "shaders/part.glsl:1: error: '(' : syntax error, unexpected SEMICOLON\n",
        "shaders/main.comp:0: error: 'x' : no matching overloaded function found\n",
        "<raxel/thread.glsl>:5: error: '#error' : x\n",
        "cannot convert from ' const 3-component vector of float' to ' temp int'\n",
    ]),
    seeds: &[],
    longest: 8 << 10,
    quick: 100,
};

/// The file of the input.
const PATH: &str = "shaders/main.comp";

fn run(input: &[u8]) {
    let files = MemoryFiles::default();
    projects::add(&files, PATH, input);
    let output = raxel_diagnostics::Files::read(&files, "output").unwrap_or_default();
    let output = String::from_utf8_lossy(&output);
    for path in [PATH, "shaders/main.hlsl"] {
        if path != PATH {
            files.insert(path, input);
        }
        let (found, texts) = raxel_shader::fuzzing::read(&files, path, &output);
        check::diagnostics(&found, &texts);
    }
}
