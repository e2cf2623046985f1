//! The shader of a pass, from its inputs and outputs. All shaders do the same: a stored texel is a hash of the pass's values, of a texel
//! of each input, and of its own old value if it is loaded.

use std::fmt::Write as _;

use crate::model::{Graph, How, Pass};

/// The file that every shader includes; a reload changes the salt.
pub(crate) fn include(salt: u32) -> String {
    format!("uint mixed(uint h, uint x) {{ return ((h ^ x) * 0x9E3779B1u ^ (h >> 15)) + {salt}u; }}\n")
}

/// `mixed` of the include.
pub(crate) fn mixed(salt: u32, h: u32, x: u32) -> u32 {
    ((h ^ x).wrapping_mul(0x9E37_79B1) ^ (h >> 15)).wrapping_add(salt)
}

/// File name and text.
pub(crate) fn shader(graph: &Graph, pass: &Pass) -> (String, String) {
    let letter = |target: bool, image: char, buffer: char| if target { image } else { buffer };
    let mut name = String::new();
    let mut text = r#"#version 460
#include "mix.glsl"
layout(local_size_x = 64) in;
layout(push_constant) uniform Push { uint a; float b; uint k; };
"#
    .to_owned();
    if pass.common.is_some() {
        name.push('c');
        text += "layout(std140) uniform Common { uint u; uint v; } both;\n";
    }
    let mut loads = String::new();
    for (at, read) in pass.reads.iter().enumerate() {
        let target = graph.resources[read.resource].is_target();
        name.push(letter(target, 'r', 'b'));
        if target {
            let _ = writeln!(text, "layout(r32ui) readonly uniform uimage2D b{at};");
            let _ = write!(
                loads,
                "        {{ uvec2 s = uvec2(imageSize(b{at})); uint j = i % (s.x * s.y);\n          \
                 h = mixed(h, imageLoad(b{at}, ivec2(j % s.x, j / s.x)).r); }}\n"
            );
        } else {
            let _ = writeln!(text, "readonly buffer Block{at} {{ uint words[]; }} b{at};");
            let _ = writeln!(loads, "        h = mixed(h, b{at}.words[i % uint(b{at}.words.length())]);");
        }
    }
    let mut stores = String::new();
    for (slot, write) in pass.writes.iter().enumerate() {
        let at = pass.reads.len() + slot;
        let target = graph.resources[write.resource].is_target();
        let (access, step) = match write.how {
            How::Over => ("writeonly", 1),
            How::Change => ("", 1),
            How::Part => ("writeonly", 2),
        };
        name.push(match write.how {
            How::Over => letter(target, 'w', 'o'),
            How::Change => letter(target, 'x', 'm'),
            How::Part => letter(target, 'p', 'q'),
        });
        let (count, old, store) = if target {
            let _ = writeln!(text, "layout(r32ui) {access} uniform uimage2D b{at};");
            let place = format!("ivec2(i % uint(imageSize(b{at}).x), i / uint(imageSize(b{at}).x))");
            (
                format!("uint(imageSize(b{at}).x * imageSize(b{at}).y)"),
                format!("imageLoad(b{at}, {place}).r"),
                format!("imageStore(b{at}, {place}, uvec4(h))"),
            )
        } else {
            let _ = writeln!(text, "{access} buffer Block{at} {{ uint words[]; }} b{at};");
            let place = format!("b{at}.words[i]");
            (format!("uint(b{at}.words.length())"), place.clone(), format!("{place} = h"))
        };
        let common = if pass.common.is_some() { "        h = mixed(mixed(h, both.u), both.v);\n" } else { "" };
        let old = if write.how == How::Change { format!("        h = mixed(h, {old});\n") } else { String::new() };
        let _ = write!(
            stores,
            "    for (uint i = gl_LocalInvocationID.x * {step}u; i < {count}; i += {}u) {{\n        \
             uint h = mixed(mixed(mixed(k + {slot}u, a), floatBitsToUint(b)), i);\n{common}{loads}{old}        {store};\n    }}\n",
            64 * step
        );
    }
    (format!("{name}.comp"), format!("{text}void main() {{\n{stores}}}\n"))
}
