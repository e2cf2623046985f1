//! A program that drives a raxel by lines of JSON.

use std::io::Write;
use std::process::{ChildStdin, Command, Stdio};

use raxel_testing::{Running, Said, line};
use serde_json::{Value, json};

/// A conversation with a raxel.
pub(crate) struct Talk {
    pub child: Running,
    pub requests: ChildStdin,
    answers: Said<String>,
}

impl Talk {
    /// Starts it, and waits until it is ready.
    pub(crate) fn start(command: &mut Command) -> Self {
        let mut child = Running::start(command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::null()));
        let requests = child.0.stdin.take().unwrap();
        let answers = Said::by(child.0.stdout.take().unwrap(), line);
        let talk = Self { child, requests, answers };
        // A busy machine may take long for a pipeline, and reports that.
        let said = std::iter::repeat_with(|| talk.line()).find(|line| line["event"] != "compiling");
        assert_eq!(said.unwrap(), json!({ "event": "ready", "protocol": 1 }));
        talk
    }

    /// The next line: an answer or an event.
    pub(crate) fn line(&self) -> Value {
        let line = self.answers.next();
        serde_json::from_str(&line).unwrap_or_else(|error| panic!("{error}: {line:?}"))
    }

    /// Sends a line as it is, and gives the answer.
    pub(crate) fn say(&mut self, line: &str) -> Value {
        writeln!(self.requests, "{line}").unwrap();
        self.answer()
    }

    /// The event of the next edit, which is made once the request for it is sent.
    pub(crate) fn reloaded(&mut self, edit: impl FnOnce()) -> Value {
        writeln!(self.requests, "{}", json!({ "do": "wait_reload", "seconds": 60 })).unwrap();
        edit();
        self.answer()
    }

    /// The next answer.
    pub(crate) fn answer(&self) -> Value {
        loop {
            let answer = self.line();
            if answer.get("event").is_none() {
                return answer;
            }
        }
    }

    /// Asks for something that is done.
    #[track_caller]
    #[allow(clippy::needless_pass_by_value, reason = "requests are made where they are sent")]
    pub(crate) fn ask(&mut self, request: Value) -> Value {
        let answer = self.say(&request.to_string());
        assert_eq!(answer["ok"], json!(true), "{request}: {answer}");
        answer
    }
}
