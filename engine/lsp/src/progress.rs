//! Tells an editor that a check takes long, so that nobody takes the diagnostics of an earlier text for those of this one.

use std::time::{Duration, Instant};

use crossbeam_channel::{SendError, Sender};
use lsp_server::{Message, Notification, Request};
use lsp_types::notification::{Notification as _, Progress as ProgressNotification};
use lsp_types::request::{Request as _, WorkDoneProgressCreate};
use serde_json::{Value, json};

/// A check that takes longer is announced.
const LONG: Duration = Duration::from_millis(150);

/// The progress of a check that an editor shows.
pub(super) struct Progress {
    /// The editor shows it.
    is_shown: bool,
    /// The number of checks that were announced: each has a name of its own.
    count: i32,
    is_open: bool,
}

impl Progress {
    /// For an editor that greets so.
    pub(crate) fn of(greeting: &Value) -> Self {
        let is_shown = greeting["capabilities"]["window"]["workDoneProgress"] == json!(true);
        Self { is_shown, count: 0, is_open: false }
    }

    /// When a check that began then is announced. `None`: it is, or nobody would see it.
    pub(crate) fn due(&self, began: Instant) -> Option<Instant> {
        (self.is_shown && !self.is_open).then(|| began + LONG)
    }

    pub(crate) fn begin(&mut self, editor: &Sender<Message>) -> Result<(), SendError<Message>> {
        self.is_open = true;
        self.count += 1;
        let create = Request::new(
            format!("raxel/{}", self.count).into(),
            WorkDoneProgressCreate::METHOD.to_owned(),
            json!({ "token": self.token() }),
        );
        editor.send(Message::Request(create))?;
        self.tell(editor, &json!({ "kind": "begin", "title": "raxel: checking" }))
    }

    pub(crate) fn end(&mut self, editor: &Sender<Message>) -> Result<(), SendError<Message>> {
        if !std::mem::take(&mut self.is_open) {
            return Ok(());
        }
        self.tell(editor, &json!({ "kind": "end" }))
    }

    fn token(&self) -> String {
        format!("raxel/check/{}", self.count)
    }

    fn tell(&self, editor: &Sender<Message>, value: &Value) -> Result<(), SendError<Message>> {
        let params = json!({ "token": self.token(), "value": value });
        editor.send(Message::Notification(Notification::new(ProgressNotification::METHOD.to_owned(), params)))
    }
}
