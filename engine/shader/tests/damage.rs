//! Texts as they are while somebody types or a save is half done: for any text, the answer is a shader or diagnostics.

use std::sync::Arc;

use proptest::prelude::*;
use raxel_diagnostics::{MemoryFiles, SourceMap, render};
use raxel_shader::{Compiler, Request, ShaderProvider};

const SHADER: &str = include_str!("fixtures/damage/damaged.comp");
const PART: &str = "#pragma once\nfloat shade(vec3 sun) { return max(dot(sun, vec3(0.0, 1.0, 0.0)), 0.0); }\n";
const WORDS: [&str; 16] = [
    "#include \"part.glsl\"",
    "#include \"a.comp\"",
    "#if",
    "#endif\n",
    "#define",
    "#line 7\n",
    "{",
    "}",
    "(",
    ")",
    ";",
    "\"",
    "/*",
    "'",
    "é",
    "#error x\n",
];

/// Every diagnostic about these files can also be printed.
fn try_out(text: &[u8], part: &[u8]) {
    let files = MemoryFiles::new([("shaders/a.comp", text), ("shaders/part.glsl", part)]);
    let request = Request { path: "shaders/a.comp".to_owned(), entry: "main".to_owned(), defines: Vec::new() };
    let mut texts = SourceMap::default();
    match Compiler::new(Arc::new(files)).shader(&request, &mut texts) {
        Ok((shader, _)) => assert_eq!(shader.interface.entry, "main"),
        Err(found) => {
            assert!(found.iter().any(raxel_diagnostics::Diagnostic::is_error), "{found:?}");
            assert!(found.iter().all(|found| !found.message.is_empty()), "{found:?}");
            for label in found.iter().flat_map(|found| &found.labels) {
                let text = texts.get(&label.span.file).map_or("", |text| text);
                assert!(text.get(label.span.range.clone()).is_some(), "{label:?} is outside its text");
            }
            assert!(render::json(&found, &texts).lines().count() == found.len().min(render::MOST + 1));
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn half_saved_texts_are_answered(
        edits in prop::collection::vec((any::<prop::sample::Index>(), 0..12usize, 0..WORDS.len()), 0..5),
        cut in prop::option::of(any::<prop::sample::Index>()),
        in_part in any::<bool>(),
    ) {
        let mut text = if in_part { PART } else { SHADER }.as_bytes().to_vec();
        for (at, remove, insert) in edits {
            let at = at.index(text.len() + 1);
            let end = (at + remove).min(text.len());
            text.splice(at..end, WORDS[insert].bytes());
        }
        if let Some(cut) = cut {
            text.truncate(cut.index(text.len() + 1));
        }
        if in_part { try_out(SHADER.as_bytes(), &text) } else { try_out(&text, PART.as_bytes()) }
    }
}
