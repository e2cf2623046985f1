//! The language server as an editor drives it: diagnostics as you type, completion, hover, definitions.

#[path = "../common/mod.rs"]
mod common;

mod completion;
mod diagnostics;
mod fixes;
mod rename;
mod shaders;

use std::io::{BufRead, Write};
use std::path::Path;
use std::process::{ChildStdin, Command, Stdio};

use common::{Project, Running, Said, command};
use serde_json::{Value, json};

/// An editor with a server.
struct Editor {
    child: Running,
    to: ChildStdin,
    from: Said<Value>,
    id: u64,
}

fn address(path: &Path) -> String {
    format!("file://{}", path.canonicalize().unwrap().display())
}

/// The next message of a server; `None` when it has gone.
fn message(pipe: &mut impl BufRead) -> Option<Value> {
    let mut length = 0;
    loop {
        let line = common::line(pipe)?;
        match line.trim().strip_prefix("Content-Length: ") {
            Some(number) => length = number.parse().unwrap(),
            None if line.trim().is_empty() => break,
            None => {}
        }
    }
    let mut bytes = vec![0; length];
    pipe.read_exact(&mut bytes).ok()?;
    Some(serde_json::from_slice(&bytes).unwrap())
}

impl Editor {
    fn start(project: &Project) -> Self {
        Self::start_with(project, json!({}))
    }

    #[allow(clippy::needless_pass_by_value, reason = "capabilities are made where they are sent")]
    fn start_with(project: &Project, capabilities: Value) -> Self {
        Self::start_by(command(project.root(), &["lsp", "--stdio"]), capabilities)
    }

    #[allow(clippy::needless_pass_by_value, reason = "capabilities are made where they are sent")]
    fn start_by(mut command: Command, capabilities: Value) -> Self {
        let mut child = Running::start(command.stdin(Stdio::piped()).stdout(Stdio::piped()));
        let (to, from) = (child.0.stdin.take().unwrap(), Said::by(child.0.stdout.take().unwrap(), message));
        let mut editor = Self { child, to, from, id: 0 };
        let greeting = editor.ask("initialize", json!({ "capabilities": capabilities }));
        assert_eq!(greeting["serverInfo"]["name"], "raxel");
        editor.tell("initialized", json!({}));
        editor
    }

    fn send(&mut self, message: &Value) {
        let text = message.to_string();
        write!(self.to, "Content-Length: {}\r\n\r\n{text}", text.len()).unwrap();
        self.to.flush().unwrap();
    }

    #[allow(clippy::needless_pass_by_value, reason = "requests are made where they are sent")]
    fn tell(&mut self, method: &str, params: Value) {
        self.send(&json!({ "jsonrpc": "2.0", "method": method, "params": params }));
    }

    #[allow(clippy::needless_pass_by_value, reason = "requests are made where they are sent")]
    fn answer(&mut self, method: &str, params: Value) -> Value {
        self.id += 1;
        let id = self.id;
        self.send(&json!({ "jsonrpc": "2.0", "id": id, "method": method, "params": params }));
        loop {
            let message = self.from.next();
            if message["id"] == json!(id) {
                return message;
            }
        }
    }

    fn ask(&mut self, method: &str, params: Value) -> Value {
        let message = self.answer(method, params);
        assert!(message["error"].is_null(), "{message}");
        message["result"].clone()
    }

    /// Why a request is refused.
    fn refused(&mut self, method: &str, params: Value) -> String {
        let message = self.answer(method, params);
        message["error"]["message"].as_str().unwrap_or_else(|| panic!("{message}")).to_owned()
    }

    fn open(&mut self, path: &Path, text: &str) {
        let document = json!({ "uri": address(path), "languageId": "x", "version": 1, "text": text });
        self.tell("textDocument/didOpen", json!({ "textDocument": document }));
    }

    fn change(&mut self, path: &Path, text: &str) {
        let document = json!({ "uri": address(path), "version": 2 });
        self.tell("textDocument/didChange", json!({ "textDocument": document, "contentChanges": [{ "text": text }] }));
    }

    /// The next diagnostics of a file.
    fn diagnostics(&mut self, path: &Path) -> Vec<Value> {
        loop {
            let message = self.from.next();
            if message["method"] == "textDocument/publishDiagnostics"
                && message["params"]["uri"] == json!(address(path))
            {
                return message["params"]["diagnostics"].as_array().unwrap().clone();
            }
        }
    }

    /// The completions at `|` in a text of the file.
    fn offered(&mut self, path: &Path, text: &str) -> Vec<String> {
        let place = self.place(path, text);
        let items = self.ask("textDocument/completion", place);
        items.as_array().unwrap().iter().map(|item| item["label"].as_str().unwrap().to_owned()).collect()
    }

    /// Sends a text without its `|`, and gives the position of it.
    fn place(&mut self, path: &Path, text: &str) -> Value {
        let at = text.find('|').unwrap();
        self.change(path, &text.replacen('|', "", 1));
        let line = text[..at].matches('\n').count();
        let character = text[..at].rsplit('\n').next().unwrap().encode_utf16().count();
        json!({ "textDocument": { "uri": address(path) }, "position": { "line": line, "character": character } })
    }
}

/// Where something is declared: the file, and the line from 0.
fn place_of(found: &Value) -> (&str, u64) {
    (found["uri"].as_str().unwrap_or_default(), found["range"]["start"]["line"].as_u64().unwrap_or(u64::MAX))
}

/// The edits of a rename in a file, as the texts that they replace by line.
fn edits_in<'v>(edit: &'v Value, path: &Path) -> Vec<&'v Value> {
    edit["changes"][address(path)].as_array().map(|edits| edits.iter().collect()).unwrap_or_default()
}

const NOTE: &str = include_str!("../fixtures/lsp/note.comp");

const NOTES: &str = include_str!("../fixtures/lsp/note.toml");

fn notes() -> (Project, Editor, std::path::PathBuf, std::path::PathBuf) {
    let project = Project::empty();
    project.write("graphs/note.toml", NOTES).write("shaders/note.comp", NOTE);
    project.write(
        "graphs/more.toml",
        r#"extends = "note.toml"
[[passes]]
name = "note"
bind = { outColor = "color" }
push.time = "param.speed"
"#,
    );
    let mut editor = Editor::start(&project);
    let (graph, shader) = (project.path("graphs/note.toml"), project.path("shaders/note.comp"));
    editor.open(&graph, NOTES);
    editor.open(&shader, NOTE);
    (project, editor, graph, shader)
}

/// The byte of a position in a text.
fn byte_at(text: &str, position: &Value) -> usize {
    let number = |key: &str| usize::try_from(position[key].as_u64().unwrap()).unwrap();
    let start: usize = text.split_inclusive('\n').take(number("line")).map(str::len).sum();
    let mut units = number("character");
    let line = text[start..].split('\n').next().unwrap();
    let is_before = |(_, letter): &(usize, char)| {
        let before = units > 0;
        units = units.saturating_sub(letter.len_utf16());
        before
    };
    start + line.char_indices().take_while(is_before).map(|(_, letter)| letter.len_utf8()).sum::<usize>()
}
