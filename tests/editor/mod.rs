//! An editor that talks to a language server.

#![allow(dead_code, reason = "each file that uses it uses a part of it")]

use std::io::{BufRead, Write};
use std::path::Path;
use std::process::{ChildStdin, Stdio};

use serde_json::{Value, json};

use super::common::{self, Project, Running, Said, command};

/// An editor with a server.
pub struct Editor {
    pub child: Running,
    pub to: ChildStdin,
    pub from: Said<Value>,
    id: u64,
}

pub fn address(path: &Path) -> String {
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
    pub fn start(project: &Project) -> Self {
        let mut command = command(project.root(), &["lsp", "--stdio"]);
        let mut child = Running::start(command.stdin(Stdio::piped()).stdout(Stdio::piped()));
        let (to, from) = (child.0.stdin.take().unwrap(), Said::by(child.0.stdout.take().unwrap(), message));
        let mut editor = Self { child, to, from, id: 0 };
        let greeting = editor.ask("initialize", json!({ "capabilities": {} }));
        assert_eq!(greeting["serverInfo"]["name"], "raxel");
        editor.tell("initialized", json!({}));
        editor
    }

    pub fn send(&mut self, message: &Value) {
        let text = message.to_string();
        write!(self.to, "Content-Length: {}\r\n\r\n{text}", text.len()).unwrap();
        self.to.flush().unwrap();
    }

    #[allow(clippy::needless_pass_by_value, reason = "requests are made where they are sent")]
    pub fn tell(&mut self, method: &str, params: Value) {
        self.send(&json!({ "jsonrpc": "2.0", "method": method, "params": params }));
    }

    #[allow(clippy::needless_pass_by_value, reason = "requests are made where they are sent")]
    pub fn answer(&mut self, method: &str, params: Value) -> Value {
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

    pub fn ask(&mut self, method: &str, params: Value) -> Value {
        let message = self.answer(method, params);
        assert!(message["error"].is_null(), "{message}");
        message["result"].clone()
    }

    /// Why a request is refused.
    pub fn refused(&mut self, method: &str, params: Value) -> String {
        let message = self.answer(method, params);
        message["error"]["message"].as_str().unwrap_or_else(|| panic!("{message}")).to_owned()
    }

    pub fn open(&mut self, path: &Path, text: &str) {
        let document = json!({ "uri": address(path), "languageId": "x", "version": 1, "text": text });
        self.tell("textDocument/didOpen", json!({ "textDocument": document }));
    }

    pub fn change(&mut self, path: &Path, text: &str) {
        let document = json!({ "uri": address(path), "version": 2 });
        self.tell("textDocument/didChange", json!({ "textDocument": document, "contentChanges": [{ "text": text }] }));
    }

    /// The next diagnostics of a file.
    pub fn diagnostics(&mut self, path: &Path) -> Vec<Value> {
        loop {
            let message = self.from.next();
            if message["method"] == "textDocument/publishDiagnostics"
                && message["params"]["uri"] == json!(address(path))
            {
                return message["params"]["diagnostics"].as_array().unwrap().clone();
            }
        }
    }

    /// What is offered where `|` stands in a text of the file.
    pub fn offered(&mut self, path: &Path, text: &str) -> Vec<String> {
        let place = self.place(path, text);
        let items = self.ask("textDocument/completion", place);
        items.as_array().unwrap().iter().map(|item| item["label"].as_str().unwrap().to_owned()).collect()
    }

    /// Sends a text without its `|`, and gives the position of it.
    pub fn place(&mut self, path: &Path, text: &str) -> Value {
        let at = text.find('|').unwrap();
        self.change(path, &text.replacen('|', "", 1));
        let line = text[..at].matches('\n').count();
        let character = text[..at].rsplit('\n').next().unwrap().encode_utf16().count();
        json!({ "textDocument": { "uri": address(path) }, "position": { "line": line, "character": character } })
    }
}
