//! Diagnostics of shaders that do not compile, as whole text.

use std::sync::Arc;

use raxel_diagnostics::{MemoryFiles, SourceMap, render};
use raxel_shader::{Compiler, Request, ShaderProvider};

/// The diagnostics of `shaders/a.comp` among these files.
fn said<B: AsRef<[u8]>>(files: impl IntoIterator<Item = (&'static str, B)>) -> String {
    said_of("shaders/a.comp", "main", &[], files)
}

fn said_of<B: AsRef<[u8]>>(
    path: &str,
    entry: &str,
    defines: &[(&str, &str)],
    files: impl IntoIterator<Item = (&'static str, B)>,
) -> String {
    let request = Request {
        path: path.to_owned(),
        entry: entry.to_owned(),
        defines: defines.iter().map(|(name, value)| ((*name).to_owned(), (*value).to_owned())).collect(),
    };
    let mut texts = SourceMap::default();
    let found = match Compiler::new(Arc::new(MemoryFiles::new(files))).shader(&request, &mut texts) {
        Ok((_, warnings)) => warnings,
        Err(found) => {
            assert!(found.iter().any(raxel_diagnostics::Diagnostic::is_error));
            found
        }
    };
    render::human(&found, &texts, false)
}

const HEAD: &str = "#version 460\nlayout(local_size_x = 8) in;\n";

fn body(text: &str) -> String {
    format!("{HEAD}{text}")
}

#[test]
fn an_unknown_name_is_underlined() {
    insta::assert_snapshot!(said([("shaders/a.comp", body("void main() {\n    float foobar = 1.0 + foo;\n}\n"))]));
}

#[test]
fn a_wrong_type_underlines_the_line() {
    insta::assert_snapshot!(said([("shaders/a.comp", body("void main() {\n    int steps = vec3(1.0);\n}\n"))]));
}

#[test]
fn arguments_that_do_not_fit_show_the_function_that_is_meant() {
    let text = "float nearer(vec3 a, float most) { return min(a.x, most); }\nvoid main() { float b = nearer(vec2(0.0), 1.0); }\n";
    insta::assert_snapshot!(said([("shaders/a.comp", body(text))]));
    // A function of GLSL is not taken for a misspelt other one.
    let out = said([("shaders/a.comp", body("void main() { float a = mix(vec3(1.0), 2.0); float b = min(a, a); }\n"))]);
    assert!(out.contains("`mix`: no matching overloaded function") && !out.contains("did you mean"), "{out}");
    let out = said([(
        "shaders/a.comp",
        body("float nearer(float a) { return a; }\nvoid main() { float b = neerer(1.0); }\n"),
    )]);
    assert!(out.contains("help: did you mean `nearer`?"), "{out}");
}

#[test]
fn a_text_in_quotes_without_its_include_is_one_error_that_names_it() {
    let out = said([("shaders/a.comp", body("void main() { debugPrintfEXT(\"here %f\", 1.0); }\n"))]);
    assert!(out.contains("--> shaders/a.comp:3:30\n"), "{out}");
    assert!(out.contains("help: write `#include <raxel/print.glsl>`"), "{out}");
    assert_eq!(out.matches("error[").count(), 1, "{out}");
}

#[test]
fn a_missing_semicolon_is_noticed_below() {
    insta::assert_snapshot!(said([("shaders/a.comp", body("void main() {\n    float a = 1.0\n    a += 1.0;\n}\n"))]));
}

/// The compiler notices it in the file behind.
#[test]
fn a_missing_semicolon_at_the_end_of_an_include_is_shown_there() {
    for include in ["const float STEP = 0.5", "// How far.\n\nconst float STEP = 0.5\n"] {
        let main = body("#include \"step.glsl\"\nvoid main() { float far = STEP; }\n");
        let out = said([("shaders/a.comp", main), ("shaders/step.glsl", include.to_owned())]);
        let line = include.lines().position(|line| line.starts_with("const")).unwrap() + 1;
        assert!(out.contains(&format!("--> shaders/step.glsl:{line}:23\n")), "{out}");
        assert!(out.contains("^ a `;` may be missing here"), "{out}");
    }
    // A mistake on the same line is shown where it stands.
    let main = body("#include \"step.glsl\"\nvoid main() { float far = half_of(2.0); }\n");
    let include = "float half_of(float x) { return 0.5 * x }".to_owned();
    let out = said([("shaders/a.comp", main), ("shaders/step.glsl", include)]);
    assert!(out.contains("--> shaders/step.glsl:1:41\n") && out.contains("a `;` may be missing here"), "{out}");
}

#[test]
fn many_errors_are_cut_short() {
    let lines: Vec<String> = (0..30).map(|i| format!("    x{i} = 1;\n")).collect();
    let out = said([("shaders/a.comp", body(&format!("void main() {{\n{}}}\n", lines.concat())))]);
    assert_eq!(out.matches("error[RX0210]").count(), 8, "{out}");
    assert!(out.contains("more errors in this shader"), "{out}");
}

#[test]
fn an_error_in_an_include_says_by_which_way() {
    insta::assert_snapshot!(said([
        ("shaders/a.comp", body("\n#include \"lib/outer.glsl\"\nvoid main() { f(); }\n")),
        ("shaders/lib/outer.glsl", "// first\n#include \"inner.glsl\"\n".to_owned()),
        ("shaders/lib/inner.glsl", "void f() {\n    undefined_thing();\n}\n".to_owned()),
    ]));
}

#[test]
fn a_missing_include_lists_the_places() {
    insta::assert_snapshot!(said([(
        "shaders/a.comp",
        body("#include \"lightning.glsl\"\n#include <raxel/wrold.glsl>\nvoid main() { shade(); }\n")
    ),]));
}

#[test]
fn includes_stay_in_the_project() {
    insta::assert_snapshot!(said([(
        "shaders/a.comp",
        body(
            "#include \"/etc/passwd\"\n#include \"../../x.glsl\"\n#include <../../../y>\n#include \"C:/z\"\nvoid main() {}\n"
        )
    ),]));
}

#[test]
fn a_cycle_is_named() {
    insta::assert_snapshot!(said([
        ("shaders/a.comp", body("#include \"b.glsl\"\nvoid main() {}\n")),
        ("shaders/b.glsl", "#include \"c.glsl\"\n".to_owned()),
        ("shaders/c.glsl", "\n#include \"b.glsl\"\n".to_owned()),
    ]));
}

#[test]
fn a_shader_that_includes_itself_is_a_cycle() {
    let out = said([("shaders/a.comp", body("#include \"a.comp\"\nvoid main() {}\n"))]);
    assert!(out.contains("error[RX0203]: `shaders/a.comp` includes itself"), "{out}");
}

#[test]
fn protected_files_may_meet_again() {
    let out = said([
        (
            "shaders/a.comp",
            body("#include \"b.glsl\"\n#include \"b.glsl\"\n#include \"g.glsl\"\nvoid main() { b(); g(); }\n"),
        ),
        ("shaders/b.glsl", "#pragma once\n#include \"b.glsl\"\n#include \"g.glsl\"\nvoid b() { g(); }\n".to_owned()),
        ("shaders/g.glsl", "// guard\n#ifndef G\n#define G\n#include \"g.glsl\"\nvoid g() {}\n#endif\n".to_owned()),
    ]);
    assert_eq!(out, "");
}

#[test]
fn includes_have_a_floor() {
    let chain: Vec<_> =
        (0..40).map(|i| (format!("shaders/{i}.glsl"), format!("#include \"{}.glsl\"\n", i + 1))).collect();
    let files = MemoryFiles::new(chain);
    files.insert("shaders/a.comp", body("#include \"0.glsl\"\nvoid main() {}\n"));
    let request = Request { path: "shaders/a.comp".to_owned(), entry: "main".to_owned(), defines: Vec::new() };
    let found = Compiler::new(Arc::new(files)).shader(&request, &mut SourceMap::default()).unwrap_err();
    assert_eq!(found[0].code.as_str(), "RX0204");
    assert_eq!(found.len(), 1);
}

#[test]
fn includes_that_double_hit_the_cap() {
    let big = format!("// {}\n", "x".repeat(1 << 20));
    let many = "#include \"big.glsl\"\n".repeat(20);
    let out = said([("shaders/a.comp", body(&format!("{many}void main() {{}}\n"))), ("shaders/big.glsl", big)]);
    assert!(out.contains("error[RX0204]: the texts of this shader have more than 4194304 bytes"), "{out}");
}

#[test]
fn no_version_no_main_no_text() {
    insta::assert_snapshot!(
        [
            said([("shaders/a.comp", "// sky\nlayout(local_size_x = 8) in;\nvoid main() {}\n")]),
            said([("shaders/a.comp", "#version 330 core\nvoid main() {}\n")]),
            said([("shaders/a.comp", "#define N 8\n#version 460\nvoid main() {}\n")]),
            said([("shaders/a.comp", body("void mian() {}\n"))]),
            said([("shaders/a.comp", " \n// nothing\n")]),
            said([("shaders/a.comp", "")]),
            said([("shaders/b.comp", "")]),
        ]
        .join("\n")
    );
}

#[test]
fn bytes_that_are_no_text() {
    insta::assert_snapshot!(
        [
            said([("shaders/a.comp", b"#version 460\n// \xff\n".as_slice())]),
            said([("shaders/a.comp", b"#version 460\n// \0\nvoid main() {}\n".as_slice())]),
            said([
                ("shaders/a.comp", b"#version 460\n#include \"x.glsl\"\nvoid main() {}\n".as_slice()),
                ("shaders/x.glsl", b"float a;\xc3".as_slice()),
            ]),
        ]
        .join("\n")
    );
}

#[test]
fn warnings_do_not_stop_a_shader() {
    insta::assert_snapshot!(said([("shaders/a.comp", body("#extension GL_NV_nothing : warn\nvoid main() {}\n"))]));
}

#[test]
fn an_error_directive_is_an_error() {
    insta::assert_snapshot!(said([(
        "shaders/a.comp",
        body("#ifndef RX_LAYOUT\n#error no world is bound\n#endif\nvoid main() {}\n")
    )]));
}

/// The text that an `#error` stands for is missing in all that follows; a mistake before it is one all the same.
#[test]
fn what_follows_an_error_directive_is_not_told() {
    let text = "float before() { return missing; }\n#error no world is bound\n#error nor anything else\nvoid main() { trace(); }\n";
    let told = said([("shaders/a.comp", body(text))]);
    assert_eq!(told.matches("error[").count(), 3, "{told}");
    assert!(["`missing`", "no world is bound", "nor anything else"].iter().all(|part| told.contains(part)), "{told}");
}

/// The compiler prints the tokens of an `#error` with spaces between them.
#[test]
fn an_error_directive_says_what_its_author_wrote() {
    let text = "#define N 3\n  # error it's N-wide (8x8), isn't it?   // a note\nvoid main() {}\n";
    assert!(
        said([("shaders/a.comp", body(text))]).starts_with("error[RX0210]: `#error`: it's N-wide (8x8), isn't it?\n")
    );
}

#[test]
fn odd_requests_are_refused() {
    let file = [("shaders/a.comp", body("void main() {}\n"))];
    insta::assert_snapshot!(
        [
            said_of("shaders/a.comp", "shade", &[], file.clone()),
            said_of("shaders/a.comp", "main", &[("A B", "1"), ("GL_X", "1"), ("", "1"), ("N", "1\n#error")], file),
        ]
        .join("\n")
    );
}

#[test]
fn line_directives_do_no_harm() {
    let out = said([("shaders/a.comp", body("#line 900000 \"else.glsl\"\nvoid main() { oops; }\n"))]);
    assert!(out.contains("`oops`") && out.contains("else.glsl:900000"), "{out}");
    let out = said([("shaders/a.comp", body("#line 900000\nvoid main() { oops; }\n"))]);
    assert!(out.contains("`oops`"), "{out}");
}

#[test]
fn deep_expressions_neither_stop_the_process_nor_pass_for_good() {
    let sum =
        |terms: usize| body(&format!("buffer O {{ float o; }};\nvoid main() {{ o = o{}; }}\n", "+o".repeat(terms)));
    assert_eq!(said([("shaders/a.comp", sum(95_000))]), "");
    let out = said([("shaders/a.comp", sum(120_000))]);
    assert!(out.contains("error[RX0204]: a statement has more than 100000 operators"), "{}", &out[..200]);
    for (open, close) in [("(", ")"), ("- ", ""), ("sin(", ")"), ("o[int(", ")]")] {
        let text = format!("void main() {{ float o = {}1.0{}; }}\n", open.repeat(9000), close.repeat(9000));
        said([("shaders/a.comp", body(&text))]);
    }
}

/// The compiler's further messages about the same statement follow from the wrong name.
#[test]
fn a_wrong_member_is_one_error() {
    let text = r"layout(push_constant) uniform Push { float exposure; float fog; } push;
layout(rgba16f) uniform writeonly image2D colors;
vec3 tone(vec3 color) { return color; }
void main() {
    vec3 color = vec3(0.5);
    imageStore(colors, ivec2(0),
        vec4(tone(push.exposur * color), 1.0));
}
";
    insta::assert_snapshot!(said([("shaders/a.comp", body(text))]));
}

#[test]
fn a_name_that_is_missing_is_told_once_and_another_beside_it_too() {
    let text = r"vec3 f(vec3 v) { return v; }
void main() {
    vec3 a = f(colr * 2.0) + f(lihgt);
    a += f(colr);
    int n = vec3(1.0);
    a = mat2(1.0) * a * vec2(1.0);
}
";
    let told = said([("shaders/a.comp", body(text))]);
    let errors: Vec<&str> = told.lines().filter(|line| line.starts_with("error[")).collect();
    assert_eq!(errors.len(), 4, "{told}");
    assert!(errors[0].contains("`colr`") && errors[1].contains("`lihgt`"), "{told}");
    assert!(errors[2].contains("cannot convert") && errors[3].contains("wrong operand types"), "{told}");
}

/// A block is called a block, without all of its members.
#[test]
fn a_block_in_an_expression_is_not_printed_whole() {
    let text = r"layout(push_constant) uniform Push { mat4 view; float fog; } push;
struct Hit { vec3 at; float t; };
void main() {
    vec3 a = push * vec3(1.0);
    Hit hit = Hit(a, 1.0);
    float b = 2.0 * hit;
}
";
    insta::assert_snapshot!(said([("shaders/a.comp", body(text))]));
}
