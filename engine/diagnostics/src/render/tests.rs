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

/// A hundred thousand mistakes: all forms show the same twenty and count the rest, errors before warnings.
#[test]
fn many_mistakes_are_counted() {
    let texts = texts();
    let of = |index: usize| {
        let new = if index.is_multiple_of(10_000) { Diagnostic::warning } else { Diagnostic::error };
        new(files::BAD_VALUE, format!("number {index}")).label(Span::new("graphs/primary.toml", 5..6), "")
    };
    let many: Vec<Diagnostic> = (0..100_000).map(of).collect();
    let out = human(&many, &texts, false);
    assert!(out.ends_with("\nand 99,980 more errors and warnings\n"), "{out}");
    assert!(out.contains("number 20\n") && !out.contains("number 21\n") && !out.contains("number 0\n"));
    let out = short(&many, &texts);
    assert_eq!(out.lines().count(), 21);
    assert!(out.ends_with("\nand 99,980 more errors and warnings\n"), "{out}");
    let out = json(&many, &texts);
    let last: serde_json::Value = serde_json::from_str(out.lines().last().unwrap()).unwrap();
    assert_eq!(out.lines().count(), 21);
    assert_eq!(last, serde_json::json!({ "reason": "more-diagnostics", "errors": 99_970, "warnings": 10 }));

    // Where errors leave room, warnings are shown.
    let few: Vec<Diagnostic> =
        many[..10_001].iter().rev().take(5).chain(&many[..1]).cycle().take(40).cloned().collect();
    let errors = few.iter().filter(|diagnostic| diagnostic.is_error()).count();
    assert!(errors > MOST && short(&few, &texts).ends_with("errors and warnings\n"));
    let warnings: Vec<Diagnostic> = few.iter().filter(|diagnostic| !diagnostic.is_error()).cloned().collect();
    assert_eq!(short(&[&warnings[..7], &many[1..16]].concat(), &texts).lines().last(), Some("and 2 more warnings"));
    assert_eq!(short(&many[1..=MOST], &texts).lines().count(), MOST);
}

/// Words, messages and lines of megabytes do not reach the terminal, in any part of a diagnostic.
#[test]
fn what_is_long_is_cut() {
    let mut texts = SourceMap::default();
    let line = "\u{e9}".repeat(1 << 20);
    texts.insert("long", format!("{line}\n{line}\n{line}"));
    let at = |line: usize| Span::new("long", line * ((2 << 20) + 1) + 1000..line * ((2 << 20) + 1) + 1010);
    let diagnostic = Diagnostic::error(files::BAD_VALUE, format!("`{line}` begins, {} ends", "word ".repeat(1 << 18)))
        .label(at(0), "first")
        .label(at(1), line.clone())
        .label(at(2), "third")
        .note(line.clone())
        .help(line.clone());
    let all = std::slice::from_ref(&diagnostic);
    for (out, most) in [(human(all, &texts, false), 20_000), (short(all, &texts), 4000), (json(all, &texts), 40_000)] {
        assert!(out.len() < most, "{}", out.len());
        assert!(out.contains("` begins, word word"), "{out}");
    }
    let out = human(all, &texts, false);
    assert!(out.contains("first") && out.contains("third"), "{out}");
}

/// Labels that are far apart are shown without the lines between them.
#[test]
fn labels_far_apart_are_pieces() {
    let mut texts = SourceMap::default();
    texts.insert("f", format!("one\n{}two\n", "between\n".repeat(10_000)));
    let diagnostic = Diagnostic::error(files::BAD_VALUE, "m")
        .label(Span::new("f", 80_004..80_007), "the second")
        .label(Span::new("f", 0..3), "the first");
    insta::assert_snapshot!(human(&[diagnostic], &texts, false), @r"
    error[RX0014]: m
         --> f:10002:1
          |
    10002 | two
          | ^^^ the second
          |
         ::: f:1:1
          |
        1 | one
          | --- the first
    ");
}

#[test]
fn a_cut_line_keeps_its_columns() {
    let text = format!("first = 1\nlong = \"{}\" # é\nwrong = 2\n", "x".repeat(1000));
    let mut texts = SourceMap::default();
    texts.insert("f.toml", &*text);
    let at = text.find('#').unwrap();
    let diagnostic = Diagnostic::error(files::BAD_VALUE, "m").label(Span::new("f.toml", at..at + 1), "here");
    let shown = human(std::slice::from_ref(&diagnostic), &texts, false);
    assert!(shown.contains("--> f.toml:2:1011\n"), "{shown}");
    assert!(shown.len() < 1200, "{shown}");
    assert!(short(&[diagnostic], &texts).starts_with("f.toml:2:1011:"));
}
