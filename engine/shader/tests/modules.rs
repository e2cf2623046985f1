//! Ready modules and HLSL; and that nothing a `.spv` file can hold does harm.

use std::sync::Arc;

use proptest::prelude::*;
use raxel_diagnostics::{Diagnostic, MemoryFiles, SourceMap, render};
use raxel_shader::interface::{Access, BindingKind};
use raxel_shader::{Compiler, Request, Shader, ShaderProvider, bytes_of};

fn request(path: &str) -> Request {
    Request { path: path.to_owned(), entry: "main".to_owned(), defines: Vec::new() }
}

fn shader<B: AsRef<[u8]>>(path: &str, bytes: B) -> Result<Arc<Shader>, Vec<Diagnostic>> {
    compile(&request(path), [(path.to_owned(), bytes)])
}

fn compile<B: AsRef<[u8]>>(
    request: &Request,
    files: impl IntoIterator<Item = (String, B)>,
) -> Result<Arc<Shader>, Vec<Diagnostic>> {
    let compiler = Compiler::new(Arc::new(MemoryFiles::new(files)));
    compiler.shader(request, &mut SourceMap::default()).map(|(shader, _)| shader)
}

fn good<B: AsRef<[u8]>>(path: &str, text: B) -> Arc<Shader> {
    shader(path, text).unwrap_or_else(|found| panic!("{}", render::human(&found, &SourceMap::default(), false)))
}

const SAMPLE: &str = include_str!("fixtures/modules/sample.comp");

/// Without its reflection's places, a module has the same interface as the text it came from.
#[test]
fn a_module_says_what_its_source_says() {
    let from_text = good("shaders/a.comp", SAMPLE);
    let ready = good("shaders/a.spv", bytes_of(&from_text.spirv));
    let strip = |shader: &Shader| {
        let text = format!("{:?}", shader.interface);
        let mut out = String::new();
        let mut rest = text.as_str();
        while let Some((before, after)) = rest.split_once("place: Some(Span {") {
            out.push_str(before);
            out.push_str("place: None");
            rest = after.split_once("})").unwrap().1;
        }
        out + rest
    };
    assert_eq!(strip(&from_text), strip(&ready));
    assert_eq!(raxel_spirv::validate(&from_text.spirv), Ok(()));
    assert!(ready.interface.push.is_some() && ready.interface.bindings.len() == 4);
    assert_eq!(ready.interface.capabilities, ["Int64"]);
    assert_eq!(ready.spirv, from_text.spirv);
    assert_eq!(ready.files, ["shaders/a.spv"]);
    assert_eq!(ready.interface.local_size[0].spec_id, Some(0));
}

#[test]
fn only_what_is_used_must_be_bound() {
    let text = include_str!("fixtures/modules/only_what_is_used.comp");
    let found = good("shaders/a.comp", text);
    let mut names: Vec<_> = found.interface.bindings.iter().map(|binding| binding.name.as_str()).collect();
    names.sort_unstable();
    assert_eq!(names, ["by_argument", "counted", "direct", "measured", "passed"]);
}

#[test]
fn constants_may_be_computed() {
    let text = include_str!("fixtures/modules/computed_constants.comp");
    let found = good("shaders/a.comp", text);
    assert_eq!(found.interface.specialization.len(), 3);
}

#[test]
fn buffer_references_are_refused() {
    // The compiler stops the process over this one.
    let text = r"#version 460
#extension GL_EXT_buffer_reference : require
layout(buffer_reference) buffer R { uint x; };
buffer Out { uint o; };
void main() { o = R(uvec2(1)).x; }
";
    let found = shader("shaders/a.comp", text).unwrap_err();
    assert_eq!((found.len(), found[0].code.as_str()), (1, "RX0164"));
    let place = found[0].labels[0].span.range.clone();
    assert_eq!(&text[place], "buffer_reference");
    let mut by_define = request("shaders/a.comp");
    by_define.defines = vec![("Q".to_owned(), "buffer_reference".to_owned())];
    let found = compile(&by_define, [("shaders/a.comp".to_owned(), text.replace("(buffer_reference)", "(Q)"))]);
    assert_eq!(found.unwrap_err()[0].code.as_str(), "RX0164");
}

#[test]
fn variables_are_counted() {
    let text = |private: &str, shared: &str| {
        format!(
            r"#version 460
struct Node {{ dvec2 a; ivec3 b; }};
shared Node pool[{shared}];
buffer Out {{ int o[]; }};
void main() {{ int large[{private}]; large[o[0]] = o[1]; pool[o[2]].b.x = 1; o[3] = large[o[4]]; }}
"
        )
    };
    let shared = |text: String| good("shaders/a.comp", text).interface.shared_bytes;
    assert_eq!(shared(text("16000", "10")), 280);
    assert_eq!(shared("#version 460\nbuffer Out { int o; };\nvoid main() { o = 1; }\n".to_owned()), 0);
    let found = shader("shaders/a.comp", text("1000000000", "10")).unwrap_err();
    assert_eq!(found[0].code.as_str(), "RX0204");
    assert!(found[0].message.contains("take 40000000"), "{}", found[0].message);
}

/// Bytes that an array of `uint` shares, whose length is an expression of `N` (9 by default, number 3).
#[test]
fn shared_arrays_have_the_length_that_constants_give_them() {
    let bytes = |length: &str, set: &[(u32, u32)]| {
        let text = format!(
            "#version 460\nlayout(constant_id = 3) const uint N = 9;\n\
             const uint LENGTH = {length};\nshared uint s[LENGTH];\n\
             buffer Out {{ uint o[]; }};\nvoid main() {{ s[o[0] % LENGTH] = 1; o[1] = s[o[2] % LENGTH]; }}\n"
        );
        good("shaders/a.comp", text).shared_bytes(&set.iter().copied().collect())
    };
    assert_eq!(bytes("N", &[]), 36);
    assert_eq!(bytes("N", &[(3, 5000)]), 20_000);
    assert_eq!(bytes("N", &[(4, 0)]), 36);
    assert_eq!(bytes("N * N - 1", &[(3, 8)]), 252);
    assert_eq!(bytes("(N << 2u) / 3u + (N & 6u)", &[]), 48);
    assert_eq!(bytes("N > 8u ? N : 8u", &[]), 36);
    assert_eq!(bytes("N > 8u ? N : 8u", &[(3, 5)]), 32);
    assert_eq!(bytes("!(N >= 8u) == (N != 9u) ? 100u : 3u", &[]), 400);
    assert_eq!(bytes("!(N >= 8u) == (N != 9u) ? 100u : 3u", &[(3, 10)]), 12);
    assert_eq!(bytes("uint(-int(N) / 2 + 20) ^ (~N & 6u)", &[]), 4 * ((20 - 4) ^ (!9 & 6)));
    assert_eq!(bytes("uvec2(N, 3).y + uvec2(N, N * 2).yx.x", &[(3, 4)]), 44);
    assert_eq!(bytes("1u + uint(N < 4u)", &[]), 4);
    assert_eq!(bytes("1u + uint(N < 4u)", &[(3, 2)]), 8);
}

/// The GLSL compiler computes these at run time, which leaves the length of the array without a value.
#[test]
fn a_length_that_is_computed_at_run_time_is_refused_with_the_way_out() {
    let text = |length: &str| {
        format!(
            "#version 460\nlayout(constant_id = 3) const uint N = 9;\nconst bool NINE = !(N == 9u);\n\
             shared uint s[{length}];\nbuffer Out {{ uint o[]; }};\nvoid main() {{ s[o[0]] = 1; o[1] = s[o[2]]; }}\n"
        )
    };
    let found = shader("shaders/a.comp", text("N >= 8u && !(N == 9u) ? 100 : 3")).unwrap_err();
    assert_eq!((found.len(), found[0].code.as_str()), (1, "RX0222"));
    assert!(
        found[0].message.ends_with("give each side of `&&` and `||` a constant of its own"),
        "{}",
        found[0].message
    );
    assert_eq!(good("shaders/a.comp", text("N >= 8u && NINE ? 100 : 3")).interface.shared_bytes, 12);
}

/// The size of the workgroup follows the constants of numbers 5 and 6.
#[test]
fn shared_arrays_may_be_as_long_as_the_workgroup() {
    let bytes = |length: &str, set: &[(u32, u32)]| {
        let text = format!(
            "#version 460\nlayout(local_size_x = 8, local_size_y = 4, local_size_x_id = 5, local_size_y_id = 6) in;\n\
             layout(constant_id = 3) const uint N = 9;\nshared uint s[{length}];\n\
             buffer Out {{ uint o[]; }};\nvoid main() {{ s[o[0]] = 1; o[1] = s[o[2]]; }}\n"
        );
        let found = good("shaders/a.comp", text);
        assert_eq!(found.interface.local_size.map(|size| (size.value, size.spec_id))[1], (4, Some(6)));
        found.shared_bytes(&set.iter().copied().collect())
    };
    assert_eq!(bytes("gl_WorkGroupSize.x", &[]), 32);
    assert_eq!(bytes("gl_WorkGroupSize.x", &[(5, 256)]), 1024);
    assert_eq!(bytes("gl_WorkGroupSize.x * gl_WorkGroupSize.y + N", &[(6, 16)]), 4 * (8 * 16 + 9));
    let most = "gl_WorkGroupSize.x > gl_WorkGroupSize.y ? gl_WorkGroupSize.x : gl_WorkGroupSize.y";
    assert_eq!(bytes(most, &[]), 32);
    assert_eq!(bytes(most, &[(6, 64)]), 256);
}

#[test]
fn bindings_have_places_of_their_own() {
    let shared = r"#version 460
layout(set = 7, binding = 9) buffer A { uint a; };
layout(set = 7, binding = 9) buffer B { uint b; };
layout(binding = 60000) uniform C { uint c; };
void main() { a = b + c; }
";
    let places = |shader: &Shader| -> Vec<_> {
        shader.interface.bindings.iter().map(|b| (b.name.clone(), b.set, b.binding)).collect()
    };
    let from_text = good("shaders/a.comp", shared);
    let expected = ["A", "B", "C"].map(str::to_owned);
    assert_eq!(places(&from_text), expected.into_iter().zip(0..).map(|(name, i)| (name, 0, i)).collect::<Vec<_>>());
    assert_eq!(raxel_spirv::validate(&from_text.spirv), Ok(()));
    let registers = r"RWTexture2D<float4> image : register(u0);
StructuredBuffer<uint> nodes : register(t0);
cbuffer Settings : register(b0) { float4 tint; };
[numthreads(1, 1, 1)]
void main() { image[int2(0, 0)] = tint * nodes[0]; }
";
    let found = places(&good("shaders/a.hlsl", registers));
    let numbers: std::collections::BTreeSet<_> = found.iter().map(|(_, set, binding)| (*set, *binding)).collect();
    assert_eq!((found.len(), numbers.len()), (3, 3), "{found:?}");
    // Numbers that are good stay.
    let kept = "#version 460\nlayout(set = 1, binding = 5) buffer A { uint a; };\nvoid main() { a = 1; }\n";
    assert_eq!(places(&good("shaders/a.comp", kept)), [("A".to_owned(), 1, 5)]);
}

#[test]
fn what_cannot_be_bound_is_named() {
    let text = r"#version 460
uniform texture2D tex; uniform sampler smp; layout(r32f) uniform imageBuffer texels; uniform samplerBuffer fetched;
layout(r32f) writeonly uniform image2D o;
void main() { imageStore(o, ivec2(0), texture(sampler2D(tex, smp), vec2(0)) + imageLoad(texels, 0) + texelFetch(fetched, 0)); }
";
    let found = good("shaders/a.comp", text);
    for binding in &found.interface.bindings {
        assert_eq!(matches!(binding.kind, BindingKind::Unsupported(_)), binding.name != "o", "{binding:?}");
    }
    assert_eq!(found.interface.bindings.len(), 5);
}

#[test]
fn hlsl_is_read_too() {
    let text = include_str!("fixtures/modules/fill.hlsl");
    let mut asked = request("shaders/a.hlsl");
    asked.entry = "shade".to_owned();
    let files = [
        ("shaders/a.hlsl".to_owned(), text),
        ("shaders/include/shared.hlsl".to_owned(), "struct Node { uint mask; uint child; };\n"),
    ];
    let found = compile(&asked, files).unwrap_or_else(|found| panic!("{found:?}"));
    let interface = &found.interface;
    assert_eq!(interface.entry, "shade");
    assert_eq!(interface.local_size.map(|size| size.value), [8, 4, 1]);
    let push: Vec<_> =
        interface.push.as_ref().unwrap().members.iter().map(|member| (member.name.as_str(), member.offset)).collect();
    assert_eq!(push, [("tint", 0), ("cell", 16), ("exposure", 28)]);
    let mut bindings: Vec<_> =
        interface.bindings.iter().map(|binding| (binding.name.as_str(), binding.access)).collect();
    bindings.sort_by_key(|(name, _)| *name);
    assert_eq!(
        bindings,
        [
            ("Settings", Access::Read),
            ("counters", Access::ReadWrite),
            ("nodes", Access::Read),
            ("outColor", Access::ReadWrite)
        ]
    );
}

fn code_of(bytes: &[u8]) -> &'static str {
    shader("shaders/a.spv", bytes).map_or_else(|found| found[0].code.as_str(), |_| "")
}

#[test]
fn broken_modules_are_refused() {
    let module = bytes_of(&good("shaders/a.comp", SAMPLE).spirv);
    assert_eq!(code_of(&module), "");
    assert_eq!(code_of(b""), "RX0220");
    assert_eq!(code_of(b"\x03\x02\x23\x07"), "RX0220");
    assert_eq!(code_of(b"#version 460\nvoid main() {}\n"), "RX0220");
    let words = |from: usize, bytes: [u8; 4]| {
        let mut changed = module.clone();
        changed[from * 4..from * 4 + 4].copy_from_slice(&bytes);
        changed
    };
    assert_eq!(code_of(&words(0, [7, 0x23, 2, 3])), "RX0221", "the other byte order");
    assert_eq!(code_of(&words(1, [0, 7, 1, 0])), "RX0221", "SPIR-V 1.7");
    assert_eq!(code_of(&words(1, [0, 0, 2, 0])), "RX0220", "SPIR-V 2.0");
    assert_eq!(code_of(&words(3, [0, 0, 0, 0])), "RX0220", "no ids");
    assert_eq!(code_of(&words(3, [2, 0, 0, 0])), "RX0220", "ids beyond the bound");
    assert_eq!(code_of(&words(5, [17, 0, 0, 0])), "RX0220", "an instruction of no words");
    for length in 0..module.len() {
        assert_eq!(code_of(&module[..length]), "RX0220", "cut to {length} bytes");
    }
    let mut asked = request("shaders/a.spv");
    asked.entry = "other".to_owned();
    let found = compile(&asked, [("shaders/a.spv".to_owned(), &module)]).unwrap_err();
    assert_eq!(found[0].code.as_str(), "RX0213");
    assert_eq!(found[0].notes, ["it has `main` (GLCompute)"]);
}

/// A module of one function and these declarations, after the usual head: `void` is 1, `main` 2, its label 3, its type 4.
fn around(declarations: &[u32]) -> Vec<u8> {
    let mut words = vec![0x0723_0203, 0x0001_0500, 0, 1 << 20, 0, 0x0002_0011, 1, 0x0003_000e, 0, 1];
    words.extend([0x0005_000f, 5, 2, u32::from_le_bytes(*b"main"), 0, 0x0006_0010, 2, 17, 1, 1, 1]);
    words.extend([0x0002_0013, 1, 0x0003_0021, 4, 1]);
    words.extend(declarations);
    words.extend([0x0005_0036, 1, 2, 0, 4, 0x0002_00f8, 3, 0x0001_00fd, 0x0001_0038]);
    bytes_of(&words)
}

#[test]
fn bombs_of_types_do_not_go_off() {
    assert_eq!(code_of(&around(&[])), "");
    // Each struct holds the one before twice: written out, 2^60 members.
    let mut doubling = vec![0x0003_0016, 10, 32];
    doubling.extend((11..70).flat_map(|id| [0x0004_001e, id, id - 1, id - 1]));
    assert_eq!(code_of(&around(&doubling)), "RX0220");
    // Each array holds the one before: as deep as a stack is not.
    let mut nesting = vec![0x0003_0016, 10, 32];
    nesting.extend((11..200_000).flat_map(|id| [0x0003_001d, id, id - 1]));
    assert_eq!(code_of(&around(&nesting)), "RX0220");
    // A struct that holds itself, and an unknown instruction.
    assert_eq!(code_of(&around(&[0x0003_001e, 10, 10])), "RX0220");
    assert_eq!(code_of(&around(&[0x0001_7fff])), "RX0220");
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 3000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn no_damage_does_harm(
        edits in prop::collection::vec((any::<prop::sample::Index>(), any::<u32>(), 0u8..5), 1..6),
        cut in prop::option::of(any::<prop::sample::Index>()),
    ) {
        static MODULE: std::sync::LazyLock<Vec<u32>> =
            std::sync::LazyLock::new(|| good("shaders/a.comp", SAMPLE).spirv.to_vec());
        let mut words = MODULE.clone();
        for (place, value, how) in edits {
            let at = place.index(words.len());
            match how {
                0 => words[at] = value,
                1 => words[at] ^= 1 << (value % 32),
                2 => words[at] = value % 300,
                3 => { words.remove(at); }
                _ => words.insert(at, MODULE[value as usize % MODULE.len()]),
            }
        }
        if let Some(cut) = cut {
            words.truncate(cut.index(words.len()));
        }
        match shader("shaders/a.spv", bytes_of(&words)) {
            Ok(found) => prop_assert_eq!(found.interface.entry.as_str(), "main"),
            Err(found) => {
                prop_assert!(found[0].code.as_str().starts_with("RX02"));
                prop_assert!(!render::human(&found, &SourceMap::default(), false).is_empty());
            }
        }
    }

    #[test]
    fn no_bytes_do_harm(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
        prop_assert!(shader("shaders/a.spv", bytes).is_err());
    }
}
