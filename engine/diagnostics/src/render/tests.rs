use super::*;
use crate::codes::{files, shader};
use crate::{Diagnostic, SourceMap, Span};

const GRAPH: &str = "name = \"primary\"\n\n[passes.push]\nfov = { type = \"i32\", from = \"camera.fov\" }\n";
const SHADER: &str = "#version 460\n\tfloat fov;   // offset 64\n";

fn span(file: &str, text: &str, word: &str) -> Span {
    let at = text.find(word).unwrap();
    Span::new(file, at..at + word.len())
}

fn texts() -> SourceMap {
    let mut texts = SourceMap::default();
    texts.insert("graphs/primary.toml", GRAPH);
    texts.insert("shaders/primary.comp", SHADER);
    texts.insert("empty", "");
    texts.insert("odd", "é\r\n\u{1b}[31m漢字\n\n𝄞");
    texts
}

fn examples() -> Vec<Diagnostic> {
    vec![
        Diagnostic::error(
            shader::COMPILE,
            "push constant `fov` is `float` at offset 64 in the shader, but the graph declares `i32`",
        )
        .label(span("graphs/primary.toml", GRAPH, "\"i32\""), "declared here")
        .label(span("shaders/primary.comp", SHADER, "fov"), "the shader says")
        .label(span("graphs/primary.toml", GRAPH, "passes"), "of this pass")
        .note("included from shaders/a.comp:6")
        .help("change the type to \"f32\"")
        .help("or the shader's to `int`"),
        Diagnostic::warning(files::UNKNOWN_KEY, "`x\ny` is unknown").label(Span::new("gone", 3..9), "here"),
        Diagnostic::error(files::NOT_FOUND, "`a` does not exist"),
    ]
}

#[test]
fn human_shows_both_places() {
    insta::assert_snapshot!(human(&examples(), &texts(), false));
}

#[test]
fn short_is_one_line_each() {
    insta::assert_snapshot!(short(&examples(), &texts()));
}

#[test]
fn json_is_one_object_each() {
    let out = json(&examples(), &texts());
    assert_eq!(out.lines().count(), 3);
    let lines: Vec<serde_json::Value> = out.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    insta::assert_snapshot!(serde_json::to_string_pretty(&lines).unwrap());
}

#[test]
fn colour_changes_nothing_but_colour() {
    let colored = human(&examples(), &texts(), true);
    assert!(colored.contains("\u{1b}["));
    let mut plain = String::new();
    let mut rest = colored.as_str();
    while let Some((before, after)) = rest.split_once("\u{1b}[") {
        plain.push_str(before);
        rest = after.split_once('m').unwrap().1;
    }
    plain.push_str(rest);
    assert_eq!(plain, human(&examples(), &texts(), false));
}

#[test]
fn no_span_is_too_odd() {
    let texts = texts();
    for file in ["empty", "odd", "gone", "", "graphs/primary.toml"] {
        for start in (0..22).chain([60, usize::MAX]) {
            for end in (0..22).chain([60, usize::MAX]) {
                #[allow(clippy::reversed_empty_ranges, reason = "reversed ranges are part of the test")]
                let diagnostic = Diagnostic::error(files::BAD_VALUE, "m")
                    .label(Span { file: file.into(), range: start..end }, "a")
                    .label(Span::new(file, 1..2), "b");
                let all = std::slice::from_ref(&diagnostic);
                assert!(human(all, &texts, false).contains("RX0014"));
                assert!(json(all, &texts).contains("RX0014"));
                assert!(short(all, &texts).contains("RX0014"));
            }
        }
    }
}

#[test]
fn a_line_of_megabytes_is_cut() {
    let mut texts = SourceMap::default();
    texts.insert("long", "x".repeat(1 << 21));
    let diagnostic =
        Diagnostic::error(files::BAD_VALUE, "m").label(Span::new("long", 1 << 20..(1 << 20) + 5), "middle");
    let out = human(&[diagnostic], &texts, false);
    assert!(out.len() < 4000 && out.contains("middle"), "{}", out.len());
}

#[test]
fn columns_count_characters() {
    let text = "é\nab漢c";
    assert_eq!(position(text, 0), Position { line: 1, column: 1 });
    assert_eq!(position(text, 1), Position { line: 1, column: 1 });
    assert_eq!(position(text, 8), Position { line: 2, column: 4 });
    assert_eq!(position(text, 99), Position { line: 2, column: 5 });
}
