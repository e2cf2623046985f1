//! How long the language server takes to answer, in the largest project that raxel ships: its own. Each request follows a change of the text, as
//! when somebody types.
//!
//! `cargo bench --bench lsp`

#[path = "../tests/common/mod.rs"]
mod common;
#[path = "../tests/editor/mod.rs"]
mod editor;

use std::time::Instant;

use common::Project;
use editor::{Editor, address};
use serde_json::{Value, json};

/// How often each request is asked.
const TIMES: usize = 200;

/// Files, what stands where the cursor is put, and the requests that are asked there.
const PLACES: [(&str, &str, &[&str]); 4] = [
    (
        "graphs/beauty.toml",
        "sun_light\" }",
        &["completion", "hover", "definition", "references", "documentSymbol", "inlayHint"],
    ),
    (
        "shaders/light/beauty/average.comp",
        "released(",
        &["completion", "hover", "definition", "references", "signatureHelp"],
    ),
    ("worlds/valley.toml", "op  ", &["completion", "hover", "documentSymbol"]),
    ("worlds/dusk.demo.toml", "time", &["completion", "hover", "documentSymbol"]),
];

fn main() {
    let project = Project::shipped();
    let mut editor = Editor::start(&project);
    println!("{:<28} {:<16} {:>9} {:>9} {:>9}", "file", "request", "p50", "p95", "largest");
    for (path, word, requests) in PLACES {
        let file = project.path(path);
        let text = std::fs::read_to_string(&file).expect("raxel ships it");
        editor.open(&file, &text);
        let at = text.find(word).expect("the file has it");
        let line = text[..at].matches('\n').count();
        let character = text[..at].rsplit('\n').next().unwrap_or_default().encode_utf16().count();
        for request in requests {
            let mut times: Vec<f64> =
                (0..TIMES).map(|time| ask(&mut editor, &file, &text, request, ([line, character], time))).collect();
            times.sort_by(f64::total_cmp);
            let [p50, p95, most] = [TIMES / 2, TIMES * 95 / 100, TIMES - 1].map(|at| format!("{:.2} ms", times[at]));
            println!("{path:<28} {request:<16} {p50:>9} {p95:>9} {most:>9}");
        }
    }
}

/// Changes the text and asks. Gives the milliseconds until the answer.
fn ask(
    editor: &mut Editor,
    file: &std::path::Path,
    text: &str,
    request: &str,
    ([line, character], time): ([usize; 2], usize),
) -> f64 {
    let start = Instant::now();
    editor.change(file, &format!("{text}{}", " ".repeat(time % 7)));
    let mut params = json!({
        "textDocument": { "uri": address(file) },
        "position": { "line": line, "character": character + 1 },
        "context": { "includeDeclaration": true },
    });
    if request == "inlayHint" {
        params["range"] = json!({ "start": { "line": 0, "character": 0 }, "end": { "line": 1000, "character": 0 } });
    }
    let answer: Value = editor.answer(&format!("textDocument/{request}"), params);
    assert!(answer["error"].is_null(), "{request}: {answer}");
    start.elapsed().as_secs_f64() * 1e3
}
