//! Prints of passes, in the form for the terminal and for programs.

use std::time::{Duration, Instant};

use raxel_diagnostics::names::grouped;
use raxel_execute::PassPrints;
use raxel_runtime::session::Session;
use serde_json::{Value, json};

use crate::console::{self, Console, Format};

/// Lines that a window writes to the terminal in a second: a terminal that scrolls faster would hold up frames.
const MOST_LINES: usize = 200;

/// A line of text for each line that a pass printed, and for each call that lost lines.
pub fn lines(prints: &PassPrints) -> Vec<String> {
    let PassPrints { frame, pass, .. } = prints;
    let of = |place: &Option<(std::sync::Arc<str>, u32)>| match place {
        Some((file, line)) => format!("{file}:{line}: `{pass}`, frame {frame}"),
        None => format!("`{pass}`, frame {frame}"),
    };
    let printed = prints.lines.iter().map(|line| {
        let [x, y, z] = line.invocation;
        format!("{}, ({x}, {y}, {z}): {}", of(&line.place), line.text)
    });
    let omitted =
        prints.omitted.iter().map(|omitted| format!("{}: and {} more", of(&omitted.place), grouped(omitted.count)));
    printed.chain(omitted).collect()
}

/// The event for programs.
pub fn event(prints: &PassPrints) -> Value {
    let place = |place: &Option<(std::sync::Arc<str>, u32)>| match place {
        Some((file, line)) => (json!(&**file), json!(line)),
        None => (Value::Null, Value::Null),
    };
    let lines = prints.lines.iter().map(|printed| {
        let (file, line) = place(&printed.place);
        json!({ "file": file, "line": line, "invocation": printed.invocation, "text": printed.text })
    });
    let omitted = prints.omitted.iter().map(|omitted| {
        let (file, line) = place(&omitted.place);
        json!({ "file": file, "line": line, "count": omitted.count })
    });
    json!({
        "event": "printed",
        "pass": prints.pass,
        "frame": prints.frame,
        "lines": lines.collect::<Vec<_>>(),
        "omitted": omitted.collect::<Vec<_>>(),
    })
}

/// Says all that passes of a session have printed since the last call.
pub fn print_prints(session: &mut Session, console: &Console) {
    for prints in session.take_prints() {
        say(&prints, console);
    }
}

fn say(prints: &PassPrints, console: &Console) {
    if console.format() == Format::Json {
        console::event(&event(prints));
    } else {
        // One message: a window writes many lines a frame.
        console.message(&lines(prints).join("\n"));
    }
}

/// Shows prints of passes while a window is open: a repeated print only once, and no more in a second than a person can read.
pub struct PrintLog {
    last: Vec<PassPrints>,
    second: Instant,
    said: usize,
    left_out: usize,
}

impl Default for PrintLog {
    fn default() -> Self {
        Self { last: Vec::new(), second: Instant::now(), said: 0, left_out: 0 }
    }
}

impl PrintLog {
    /// Prints the new ones.
    pub fn say(&mut self, prints: &[PassPrints], console: &Console) {
        if self.second.elapsed() >= Duration::from_secs(1) {
            if self.left_out > 0 {
                console.message(&format!("passes have printed {} lines more", grouped(self.left_out)));
            }
            (self.second, self.said, self.left_out) = (Instant::now(), 0, 0);
        }
        for prints in prints {
            let last = self.last.iter_mut().find(|last| last.pass == prints.pass);
            let again =
                last.as_ref().is_some_and(|last| (&last.lines, &last.omitted) == (&prints.lines, &prints.omitted));
            match last {
                Some(last) => last.clone_from(prints),
                None => self.last.push(prints.clone()),
            }
            if again {
                continue;
            }
            let room = MOST_LINES - self.said.min(MOST_LINES);
            let mut shown = prints.clone();
            shown.lines.truncate(room);
            if room == 0 {
                shown.omitted.clear();
            }
            self.said += shown.lines.len();
            self.left_out += prints.lines.len() - shown.lines.len();
            if !shown.lines.is_empty() {
                say(&shown, console);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use raxel_execute::{Omitted, PrintedLine};

    use super::*;

    #[test]
    fn lines_say_where_they_come_from() {
        let place = Some(("shaders/a.comp".into(), 7));
        let line = PrintedLine { place: place.clone(), invocation: [3, 4, 0], text: "depth 1.5".to_owned() };
        let prints = PassPrints {
            frame: 12,
            pass: "sky".to_owned(),
            lines: vec![line],
            omitted: vec![Omitted { place, count: 9998 }],
            assertions: Vec::new(),
            out_of_bounds: Vec::new(),
            written: None,
        };
        assert_eq!(
            lines(&prints),
            [
                "shaders/a.comp:7: `sky`, frame 12, (3, 4, 0): depth 1.5",
                "shaders/a.comp:7: `sky`, frame 12: and 9,998 more"
            ]
        );
        let event = event(&prints);
        assert_eq!(event["lines"][0]["invocation"], json!([3, 4, 0]));
        assert_eq!(event["omitted"], json!([{ "file": "shaders/a.comp", "line": 7, "count": 9998 }]));
    }
}
