//! How long the language server takes to answer in the largest project that raxel ships, its own. A change of the text comes before each request,
//! as when somebody types.
//!
//! `cargo bench -p raxel-lsp --bench answers`

#![allow(missing_docs, reason = "a benchmark")]

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use criterion::{Criterion, criterion_group, criterion_main};
use lsp_server::{Connection, Message, Notification, Request};
use lsp_types::Url;
use serde_json::{Value, json};

/// The largest graph, and a large shader of it, each with the word that requests are about.
const GRAPH: (&str, &str) = ("graphs/beauty.toml", "param.mist_height");
const SHADER: (&str, &str) = ("shaders/light/beauty/gloss.comp", "rx_trace");

/// An editor that has one file open.
struct Editor {
    server: Connection,
    address: Url,
    text: String,
    /// Number of requests and edits so far.
    count: i32,
}

impl Editor {
    fn open(path: &str) -> Self {
        let (server, editor) = Connection::memory();
        std::thread::spawn(|| raxel_lsp::serve(editor));
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
        let file: PathBuf = root.join(path).canonicalize().expect("raxel ships it");
        let text = std::fs::read_to_string(&file).expect("raxel ships it");
        let address = Url::from_file_path(file).expect("it is absolute");
        let mut editor = Self { server, address, text, count: 0 };
        editor.ask("initialize", json!({ "capabilities": {} }));
        editor.tell("initialized", json!({}));
        let document = json!({ "uri": editor.address, "languageId": "x", "version": 0, "text": editor.text });
        editor.tell("textDocument/didOpen", json!({ "textDocument": document }));
        editor
    }

    /// The position of the last letter of a word.
    fn position(&self, word: &str) -> Value {
        let at = self.text.find(word).expect("the file has it") + word.len() - 1;
        let line = self.text[..at].matches('\n').count();
        let column = self.text[..at].rsplit('\n').next().unwrap_or_default().encode_utf16().count();
        json!({ "line": line, "character": column })
    }

    fn tell(&self, method: &str, params: Value) {
        let told = Notification::new(method.to_owned(), params);
        self.server.sender.send(Message::Notification(told)).expect("the server is there");
    }

    /// Types something that the text did not have before: a comment, or else a mistake.
    fn change(&mut self, comment: bool) {
        let is_toml = self.address.path().rsplit('.').next() == Some("toml");
        let of_comment = if is_toml { "#" } else { "//" };
        self.end_with(if comment { of_comment } else { "mistake" });
    }

    /// Puts a line at the end of the text.
    fn end_with(&mut self, mark: &str) {
        self.count += 1;
        let text = format!("{}{mark} {}\n", self.text, self.count);
        let document = json!({ "uri": self.address, "version": self.count });
        let changed = json!({ "textDocument": document, "contentChanges": [{ "text": text }] });
        self.tell("textDocument/didChange", changed);
    }

    fn ask(&mut self, method: &str, params: Value) -> Value {
        self.count += 1;
        let request = Request::new(self.count.into(), method.to_owned(), params);
        self.server.sender.send(Message::Request(request)).expect("the server is there");
        loop {
            if let Message::Response(answer) = self.server.receiver.recv().expect("the server is there") {
                assert!(answer.error.is_none(), "{method}: {answer:?}");
                return answer.result.unwrap_or_default();
            }
        }
    }

    /// Waits for the diagnostics of the file.
    fn diagnostics(&self) -> Value {
        loop {
            if let Message::Notification(told) = self.server.receiver.recv().expect("the server is there")
                && told.params["uri"] == json!(self.address)
            {
                return told.params["diagnostics"].clone();
            }
        }
    }
}

/// What an editor asks for.
const REQUESTS: [&str; 9] = [
    "completion",
    "hover",
    "definition",
    "references",
    "rename",
    "documentSymbol",
    "inlayHint",
    "signatureHelp",
    "codeAction",
];

/// In the arguments of a call in the shader.
const ARGUMENT: &str = "rx_trace_places(rx_ray";

/// A mistake in each file, which a fix is asked for: one adds a member to `push`, the other has "did you mean".
fn mistake(editor: &Editor, file: (&str, &str)) -> Value {
    let last = editor.position(file.1);
    let column = last["character"].as_u64().expect("it is a number") + 1;
    let at = |column: u64| json!({ "line": last["line"], "character": column });
    let range = json!({ "start": at(column - file.1.len() as u64), "end": at(column) });
    let (code, message) = if file == GRAPH {
        ("RX0110", "push constant `mist_height` of the shader has no value in pass `air`")
    } else {
        ("RX0301", "`rx_trace`: undeclared identifier; did you mean `rx_trace_places`?")
    };
    json!({ "range": range, "source": "raxel", "code": code, "message": message })
}

fn answers(criterion: &mut Criterion) {
    for file in [GRAPH, SHADER] {
        let mut editor = Editor::open(file.0);
        let mut group = criterion.benchmark_group(file.0);
        group.sample_size(20);
        for request in REQUESTS {
            let is_shader = file == SHADER;
            let params = json!({
                "textDocument": { "uri": editor.address },
                "position": editor.position(if request == "signatureHelp" && is_shader { ARGUMENT } else { file.1 }),
                "range": { "start": { "line": 0, "character": 0 }, "end": { "line": 1000, "character": 0 } },
                "context": { "includeDeclaration": true, "triggerKind": 1, "isRetrigger": false, "diagnostics": [mistake(&editor, file)] },
                "newName": "another_name",
            });
            // A name of the shader library cannot be changed, and a graph has no calls.
            if request == "rename" && is_shader || request == "signatureHelp" && !is_shader {
                continue;
            }
            if matches!(request, "signatureHelp" | "codeAction") {
                let answer = editor.ask(&format!("textDocument/{request}"), params.clone());
                assert!(answer.as_array().map_or(!answer.is_null(), |all| !all.is_empty()), "{request}: {answer}");
            }
            group.bench_function(request, |bencher| {
                bencher.iter(|| {
                    editor.change(true);
                    editor.ask(&format!("textDocument/{request}"), params.clone())
                });
            });
        }
        group.finish();
    }
}

/// The beginning of a line that the compiler warns of. A first look tells errors alone.
const WARNED: &str = "#extension GL_NV_nothing : warn //";

/// From the key that mends a text to the diagnostics that are taken back. The quiet time that the server waits for is part of the figure.
fn diagnostics(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("diagnostics after a key");
    group.sample_size(10);
    for (file, mistake) in [(GRAPH, "mistake"), (SHADER, "mistake"), (SHADER, WARNED)] {
        let mut editor = Editor::open(file.0);
        let whole = if mistake == WARNED { ", the whole check" } else { "" };
        group.bench_function(format!("{}{whole}", file.0), |bencher| {
            bencher.iter_custom(|times| {
                let mut spent = Duration::ZERO;
                for _ in 0..times {
                    editor.end_with(mistake);
                    while editor.diagnostics().as_array().is_none_or(Vec::is_empty) {}
                    editor.change(true);
                    let start = Instant::now();
                    while editor.diagnostics().as_array().is_none_or(|found| !found.is_empty()) {}
                    spent += start.elapsed();
                }
                spent
            });
        });
    }
    group.finish();
}

criterion_group!(benches, answers, diagnostics);
criterion_main!(benches);
