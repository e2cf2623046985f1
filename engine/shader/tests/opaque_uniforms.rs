//! Uniform values that a driver cannot fold into a shader: the module stays valid, and every value that is loaded is hidden.

use std::sync::Arc;

use raxel_diagnostics::{MemoryFiles, SourceMap, render};
use raxel_shader::{Compiler, Request, ShaderProvider};
use raxel_spirv::Module;

const LOAD: u32 = 61;
const BITWISE_OR: u32 = 197;

/// The module of a shader with these declarations and this body, and the same with its uniform values hidden.
fn modules(declarations: &str, body: &str) -> (Arc<[u32]>, Option<Vec<u32>>) {
    let text = format!(
        r"#version 460
layout(local_size_x = 8) in;
layout(std430) buffer Out {{ uint o[]; }};
{declarations}
void main() {{ uint k = gl_LocalInvocationIndex; {body} }}
"
    );
    let files = MemoryFiles::new([("shaders/a.comp", text.as_bytes())]);
    let request = Request { path: "shaders/a.comp".to_owned(), entry: "main".to_owned(), defines: Vec::new() };
    let mut texts = SourceMap::default();
    let (shader, _) = Compiler::new(Arc::new(files))
        .shader(&request, &mut texts)
        .unwrap_or_else(|found| panic!("{}", render::human(&found, &texts, false)));
    let opaque = Module::new(&shader.spirv, "main").unwrap().with_opaque_uniforms();
    (shader.spirv.clone(), opaque)
}

fn count(words: &[u32], opcode: u32) -> usize {
    let (mut at, mut count) = (5, 0);
    while let Some(first) = words.get(at) {
        count += usize::from(first & 0xffff == opcode);
        at += (first >> 16) as usize;
    }
    count
}

#[test]
fn every_uniform_value_is_hidden() {
    let block = "layout(std140) uniform U { uint n; float f; vec3 v; ivec2 i; mat4 m; uint list[4]; } u;";
    let push = "layout(push_constant) uniform P { int n; vec4 v; bool on; } p;";
    for (declarations, body, hidden) in [
        (block, "if (u.n > 3u) o[k] = 1u;", 1),
        (block, "if (u.f > 0.5) o[k] = 1u;", 1),
        (block, "if (u.v.x > 0.5) o[k] = uint(u.i.y);", 2),
        (block, "if (u.v != vec3(1.0)) o[k] = uint(u.i == ivec2(3));", 2),
        (block, "o[k] = u.list[k & 3u];", 1),
        (push, "for (int i = 0; i < p.n; ++i) o[k + i] = 1u;", 1),
        (push, "if (p.on) o[k] = uint(p.v.x);", 2),
        // The module has the number of workgroups already.
        (push, "if (p.on) o[k] = gl_NumWorkGroups.y;", 1),
    ] {
        let (module, opaque) = modules(declarations, body);
        let opaque = opaque.unwrap_or_else(|| panic!("{body}: nothing is hidden"));
        assert_eq!(raxel_spirv::validate(&opaque), Ok(()), "{body}");
        assert_eq!(count(&opaque, BITWISE_OR) - count(&module, BITWISE_OR), hidden, "{body}");
        // One more load each: the number of workgroups.
        assert_eq!(count(&opaque, LOAD) - count(&module, LOAD), hidden, "{body}");
    }
}

#[test]
fn a_module_without_uniform_values_stays_as_it_is() {
    for (declarations, body) in [
        ("", "o[k] = k;"),
        ("layout(std430) buffer In { uint a[]; };", "if (a[k] > 3u) o[k] = a[0];"),
        ("layout(std140) uniform U { uint n; } u;", "o[k] = k;"),
    ] {
        assert_eq!(modules(declarations, body).1, None, "{body}");
    }
}
