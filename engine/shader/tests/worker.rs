//! Compiling in child processes: this program is its own child, so it has a `main` of its own, and its tests follow each other.

use std::process::ExitCode;
use std::sync::Arc;

use raxel_diagnostics::{MemoryFiles, SourceMap, render};
use raxel_shader::worker::{self, CompileLimits};
use raxel_shader::{Compiler, Request, ShaderProvider};

/// `struct` by a macro, which the look at the text before compiling does not see through.
const DOUBLING: &str = "#define DOUBLE(n, p) struct n { p a; p b; };\n";

fn main() -> ExitCode {
    let limits = CompileLimits { seconds: 2, bytes: 512 << 20 };
    worker::isolate_by(std::env::current_exe().expect("a program has a path"), limits);
    if let Some(code) = worker::isolate() {
        return code;
    }
    for test in [
        what_is_right_compiles_with_its_includes,
        a_text_that_takes_for_ever_is_given_up,
        a_text_that_takes_all_memory_is_given_up,
        a_text_that_breaks_the_compiler_down_is_given_up,
    ] {
        test();
        // Each time the next shader has a child again.
        what_is_right_compiles_with_its_includes();
    }
    ExitCode::SUCCESS
}

/// The diagnostics of a shader: codes and messages, one a line.
fn said(path: &str, text: &str) -> String {
    let part = "#pragma once\nfloat part() { return TWICE(2.0); }\n";
    let files = MemoryFiles::new([(path, text), ("shaders/part.glsl", part), ("shaders/deep/part.glsl", part)]);
    let defines = vec![("SIDE".to_owned(), "8".to_owned())];
    let request = Request { path: path.to_owned(), entry: "main".to_owned(), defines };
    let mut texts = SourceMap::default();
    match Compiler::new(Arc::new(files)).shader(&request, &mut texts) {
        Ok((shader, warnings)) => {
            assert_eq!(raxel_spirv::validate(&shader.spirv), Ok(()));
            assert_eq!(shader.files.len(), text.matches("#include").count() + 1);
            render::short(&warnings, &texts)
        }
        Err(found) => render::short(&found, &texts),
    }
}

fn doubling(levels: usize, use_of_the_last: &str) -> String {
    let double = |i| format!("DOUBLE(A{i}, A{})\n", i - 1);
    let structs: String = (1..=levels).map(double).collect();
    format!("#version 460\n{DOUBLING}struct A0 {{ int x; }};\n{structs}{use_of_the_last}")
}

fn what_is_right_compiles_with_its_includes() {
    let text = r#"#version 460
#define TWICE(x) (2.0 * x)
#include "part.glsl"
#include "deep/part.glsl"
layout(local_size_x = SIDE) in;
buffer O { float o; };
void main() { o = part(); }
"#;
    assert!(said("shaders/a.comp", text).contains("function already has a body"));
    assert_eq!(said("shaders/a.comp", &text.replace("#include \"deep/part.glsl\"\n", "")), "");
    assert!(said("shaders/a.comp", &text.replace("deep/", "none/")).contains("RX0201"));
    assert_eq!(
        said("shaders/a.hlsl", "RWStructuredBuffer<uint> o;\n[numthreads(8, 1, 1)] void main() { o[0] = 1; }"),
        ""
    );
}

fn a_text_that_takes_for_ever_is_given_up() {
    let said =
        said("shaders/a.comp", &doubling(40, "layout(std430) buffer B { A40 b; };\nvoid main() { b.a = b.b; }\n"));
    assert!(said.contains("RX0204") && said.contains("more than 2 s and was given up"), "{said}");
}

fn a_text_that_takes_all_memory_is_given_up() {
    let said = said("shaders/a.comp", &doubling(20, "void main() { A20 v, w; if (v == w) v = w; }\n"));
    assert!(said.contains("RX0204") && said.contains("more than 512 MiB and was given up"), "{said}");
}

/// One of the mistakes over which glslang follows a null pointer, with nothing in it that the look at the text finds.
fn a_text_that_breaks_the_compiler_down_is_given_up() {
    let text = r"struct Push { float k; };
[[vk::push_constant]] ConstantBuffer<Push> push;
RWStructuredBuffer<float> o;
[numthreads(8, 1, 1)] void main() { o[0] = push.k ++ .y; }
";
    let said = said("shaders/a.hlsl", text);
    assert!(said.contains("RX0210") && said.contains("breaks down"), "{said}");
}
