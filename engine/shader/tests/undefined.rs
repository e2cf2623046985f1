//! Calls whose result is undefined are found by their constants, and reported with their place.

use std::sync::Arc;

use raxel_diagnostics::{MemoryFiles, SourceMap, render};
use raxel_shader::{Compiler, Request, ShaderProvider};

/// The diagnostics of a shader whose `main` is `body`. It has the numbers `x` (float), `i` and `u` that no compiler knows.
fn said(body: &str) -> String {
    let text = format!(
        r"#version 460
layout(local_size_x = 8) in;
layout(push_constant) uniform Push {{ float x; int i; uint u; vec3 v; }};
layout(std430) buffer Out {{ float result[]; }};
{LIBRARY}void main() {{
    {body}
}}
"
    );
    let path = "shaders/a.comp".to_owned();
    let request = Request { path: path.clone(), entry: "main".to_owned(), defines: Vec::new() };
    let mut texts = SourceMap::default();
    let compiler = Compiler::new(Arc::new(MemoryFiles::new([(path, text)])));
    let (Ok((_, found)) | Err(found)) = compiler.shader(&request, &mut texts);
    render::human(&found, &texts, false)
}

/// Nothing calls it, so it has no diagnostic.
const LIBRARY: &str = "float unused(float x) { return smoothstep(1.0, 0.0, x); }\n";

#[test]
fn descending_edges_are_said_with_the_mend() {
    insta::assert_snapshot!(said("result[0] = smoothstep(0.55, 0.0, abs(x));"));
}

#[test]
fn each_rule_is_found_by_constants_alone() {
    for (wrong, right) in [
        ("result[0] = smoothstep(0.5, 0.5, x);", "result[0] = smoothstep(0.4, 0.5, x);"),
        (
            "result[0] = smoothstep(vec3(0, 1, 0), vec3(1, 0, 1), v).x;",
            "result[0] = smoothstep(vec3(0), vec3(1), v).x;",
        ),
        ("result[0] = clamp(x, 1.0, 0.0);", "result[0] = clamp(x, 1.0, 1.0);"),
        ("result[0] = clamp(i, 1, -1);", "result[0] = clamp(i, -1, 1);"),
        ("result[0] = clamp(u, 7u, 3u);", "result[0] = clamp(u, 3u, 0xffffffffu);"),
        ("result[0] = i % 0;", "result[0] = i % 3;"),
        ("result[0] = u / 0u;", "result[0] = u / 2u;"),
        ("result[0] = u << 32;", "result[0] = u << 31;"),
        ("result[0] = i >> -1;", "result[0] = i >> 1;"),
        ("result[0] = bitfieldExtract(u, 24, 9);", "result[0] = bitfieldExtract(u, 24, 8);"),
        ("result[0] = bitfieldInsert(i, 1, 31, 2);", "result[0] = bitfieldInsert(i, 1, 31, 1);"),
        // Edges that are not constant are not judged.
        ("result[0] = smoothstep(0.2, -0.2, x);", "result[0] = smoothstep(x, 0.0, 0.5);"),
    ] {
        let found = said(wrong);
        assert!(found.contains("warning[RX0217]") && found.contains("shaders/a.comp:7"), "{wrong}: {found}");
        assert_eq!(said(right), "", "{right}");
    }
}
