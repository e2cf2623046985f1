//! Shared memory: no index leaves its array, and an index in bounds costs one instruction at most.

#![allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss, reason = "a test")]

use std::sync::Arc;

use raxel_diagnostics::{MemoryFiles, SourceMap, render};
use raxel_shader::{Compiler, Request, Shader, ShaderProvider, bytes_of};

/// `OpExtInst … UMin`, and `OpUConvert`.
const EXT_INST: u32 = 12;
const U_MIN: u32 = 38;
const U_CONVERT: u32 = 113;

fn compile(path: &str, bytes: &[u8]) -> Arc<Shader> {
    let request = Request { path: path.to_owned(), entry: "main".to_owned(), defines: Vec::new() };
    let mut texts = SourceMap::default();
    let (shader, warnings) = Compiler::new(Arc::new(MemoryFiles::new([(path, bytes)])))
        .shader(&request, &mut texts)
        .unwrap_or_else(|found| panic!("{}", render::human(&found, &texts, false)));
    assert!(warnings.is_empty(), "{warnings:?}");
    assert_eq!(raxel_spirv::validate(&shader.spirv), Ok(()));
    shader
}

/// A shader with these declarations and this body.
fn of(declarations: &str, body: &str) -> Arc<Shader> {
    let text = format!(
        r"#version 460
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require
layout(local_size_x = 8, local_size_y = 8) in;
layout(std430) buffer Out {{ uint o[]; }};
{declarations}
void main() {{ uint k = gl_LocalInvocationIndex; {body} }}
"
    );
    compile("shaders/a.comp", text.as_bytes())
}

/// How often each of the instructions that bound an index stands in a module: (minimum, conversion to 32 bits).
fn bounds(shader: &Shader) -> (usize, usize) {
    let mut found = (0, 0);
    let mut at = 5;
    while let Some(first) = shader.spirv.get(at) {
        found.0 += usize::from(first & 0xffff == EXT_INST && shader.spirv[at + 4] == U_MIN);
        found.1 += usize::from(first & 0xffff == U_CONVERT);
        at += (first >> 16) as usize;
    }
    found
}

#[test]
fn every_index_that_may_leave_is_bounded() {
    for (declarations, body, expected) in [
        ("shared uint s[64];", "s[k * 100000u] = k; o[0] = s[k];", (2, 0)),
        ("shared int s[64];", "int i = int(k) - 9; s[i] = i; o[0] = s[3];", (1, 0)),
        ("shared vec4 s;", "s[k] = 1.0; o[0] = uint(s.x);", (1, 0)),
        ("shared mat4 s[2];", "s[k][k][k] = 1.0; o[0] = uint(s[1][2][3]);", (3, 0)),
        ("struct N { uint a; uint b[7]; }; shared N s[4];", "s[k].b[k] = 1u; o[0] = s[k].a;", (3, 0)),
        ("shared uint s[8][8];", "atomicAdd(s[k / 8u][k % 9u], 1u); o[0] = s[0][0];", (2, 0)),
        ("shared uint s[64];", "uint64_t i = 5ul; s[uint(i)] = k; o[0] = s[0];", (1, 1)),
        // The author's own minimum, and none beside it.
        ("shared uint s[8];", "s[min(k, 7u)] = k; o[0] = s[0];", (1, 0)),
        ("layout(constant_id = 3) const uint N = 9; shared uint s[N * 2u + 1u];", "s[k] = k; o[0] = s[k];", (2, 0)),
        ("layout(constant_id = 3) const int N = 9; shared uint s[N];", "s[k] = k; o[0] = s[4];", (2, 0)),
    ] {
        assert_eq!(bounds(&of(declarations, body)), expected, "{declarations} {body}");
    }
}

#[test]
fn what_is_not_shared_or_constant_is_left_alone() {
    for (declarations, body) in [
        ("shared uint s[4];", "s[3] = k; o[0] = s[0];"),
        ("shared uint s;", "s = k; o[k] = s;"),
        ("shared uint s[8][8];", "s[k & 7u][k % 8u] = k; o[0] = s[0][k & 3u];"),
        ("", "uint s[64]; s[k] = k; o[k] = s[k * 7u];"),
        ("const uint S[2] = uint[](1u, 2u);", "o[k * 100000u] = S[k & 1u];"),
    ] {
        assert_eq!(bounds(&of(declarations, body)), (0, 0), "{declarations} {body}");
    }
}

/// A ready module is bounded as well, also one without the instruction set that has the minimum; and no bound is laid over a bound.
#[test]
fn ready_modules_are_bounded() {
    let text = of("shared uint s[64];", "s[k * 100000u] = k; o[0] = s[k];");
    assert_eq!(bounds(&compile("shaders/a.spv", &bytes_of(&text.spirv))).0, 2);
    let specialized = of("layout(constant_id = 3) const uint N = 9; shared uint s[N];", "s[k] = k; o[0] = s[k];");
    assert_eq!(bounds(&compile("shaders/c.spv", &bytes_of(&specialized.spirv))).0, 2);

    let mut words = vec![0x0723_0203, 0x0001_0500, 0, 20, 0];
    let mut write = |opcode: u32, operands: &[u32]| {
        words.push(((operands.len() as u32 + 1) << 16) | opcode);
        words.extend_from_slice(operands);
    };
    write(17, &[1]);
    write(14, &[0, 1]);
    write(15, &[5, 1, u32::from_le_bytes(*b"main"), 0, 9, 12]);
    write(16, &[1, 17, 8, 1, 1]);
    write(71, &[12, 11, 29]);
    write(19, &[2]);
    write(33, &[3, 2]);
    // A signed index is the only integer type: `shared int s[4]`, indexed with a component of it.
    write(21, &[4, 32, 1]);
    write(43, &[4, 5, 4]);
    write(28, &[6, 4, 5]);
    write(32, &[7, 4, 6]);
    write(32, &[8, 4, 4]);
    write(59, &[7, 9, 4]);
    write(32, &[10, 1, 4]);
    write(59, &[10, 12, 1]);
    write(54, &[2, 1, 0, 3]);
    write(248, &[13]);
    write(61, &[4, 14, 12]);
    write(65, &[8, 15, 9, 14]);
    write(62, &[15, 14]);
    write(253, &[]);
    write(56, &[]);
    assert_eq!(raxel_spirv::validate(&words), Ok(()));
    assert_eq!(bounds(&compile("shaders/b.spv", &bytes_of(&words))), (1, 0));
}

/// `shared int s[LENGTH]`, indexed with a component of the invocation's id, where the length is a constant of 64 bits.
fn long_length(constant: u32) -> Vec<u32> {
    let mut words = vec![0x0723_0203, 0x0001_0500, 0, 20, 0];
    let mut write = |opcode: u32, operands: &[u32]| {
        words.push(((operands.len() as u32 + 1) << 16) | opcode);
        words.extend_from_slice(operands);
    };
    write(17, &[1]);
    write(17, &[11]);
    write(14, &[0, 1]);
    write(15, &[5, 1, u32::from_le_bytes(*b"main"), 0, 9, 12]);
    write(16, &[1, 17, 8, 1, 1]);
    write(71, &[12, 11, 29]);
    if constant == 50 {
        write(71, &[5, 1, 0]);
    }
    write(19, &[2]);
    write(33, &[3, 2]);
    write(21, &[4, 32, 0]);
    write(21, &[16, 64, 0]);
    write(constant, &[16, 5, 4, 0]);
    write(28, &[6, 4, 5]);
    write(32, &[7, 4, 6]);
    write(32, &[8, 4, 4]);
    write(59, &[7, 9, 4]);
    write(32, &[10, 1, 4]);
    write(59, &[10, 12, 1]);
    write(54, &[2, 1, 0, 3]);
    write(248, &[13]);
    write(61, &[4, 14, 12]);
    write(65, &[8, 15, 9, 14]);
    write(62, &[15, 14]);
    write(253, &[]);
    write(56, &[]);
    words
}

#[test]
fn lengths_of_64_bits_are_refused() {
    for constant in [43, 50] {
        let words = long_length(constant);
        assert_eq!(raxel_spirv::validate(&words), Ok(()));
        let refused = raxel_spirv::Module::new(&words, "main").unwrap().with_shared_bounds().unwrap_err();
        assert!(refused.to_string().contains("a constant that has not 32 bits"), "{refused}");
    }
}
