//! Control by program: requests as lines of JSON on stdin, one answer each on stdout. `raxel control` has no window and runs a frame on request;
//! `raxel run --control` is a window that a program drives too. docs/control.md describes the protocol.
//!
//! A part of raxel. Programs use the crate `raxel`; this one may change in any release.

#![cfg_attr(test, allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss))]

mod answer;
mod brush;
mod compare;
mod describe;
mod find;
mod host;
mod inputs;
mod later;
mod lines;
mod read;
mod refusal;
mod request;
mod work;
mod writers;

use std::io::BufReader;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, TryRecvError};
use std::time::{Duration, Instant};

use raxel_diagnostics::{Diagnostic, SourceMap, render};
use raxel_execute::{PassPrints, Progress};
use raxel_runtime::reload::{ProjectFile, ReloadEvent};
use raxel_runtime::session::TakeIdentity;
use raxel_runtime::{OpenError, Session};
use serde_json::{Value, json};

use self::answer::Work;
use self::find::Finding;
use self::host::Alone;
pub use self::host::{
    Brush, BrushEffect, BrushShape, CompareMode, FLY_SPEEDS, Host, InWindow, LARGEST_BRUSH, Restored,
};
use self::later::Later;
use self::read::Middle;
use self::refusal::Refusal;
use self::request::Request;
use raxel_terminal::prints;
use raxel_terminal::program::Program;
use raxel_workbench::kept::Kept;

/// How long a window answers requests before it goes on with its frame. It answers one at least.
const TURN: Duration = Duration::from_millis(4);

/// The time between two looks at an answer within a turn.
const LOOK: Duration = Duration::from_micros(100);

/// Who runs the frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Drive {
    /// Requests: nothing happens between them.
    Requests,
    /// A window, all the time.
    Window,
}

/// The end of a conversation with a program.
pub struct Control {
    lines: Receiver<Result<String, Refusal>>,
    program: Program,
    /// It was reported that the program does not read.
    complained: bool,
    drive: Drive,
    /// A request that is answered later.
    waiting: Option<Waiting>,
    /// The line after that request.
    ahead: Option<Ahead>,
    /// Each thread that reads a picture has a clone.
    reading: Arc<()>,
    /// The output of a pass within the last frame, if the session shows that instead of the frame's end.
    middle: Option<Middle>,
    /// Diagnostics of the last edit, for the request `diagnostics`.
    diagnostics: Vec<Value>,
    generation: u64,
    /// The generation that runs.
    shown: u64,
}

/// A line that was read before its turn.
struct Ahead {
    line: Result<String, Refusal>,
    /// It gives up a picture that is being kept.
    ends_keep: bool,
    /// It ends the conversation.
    quits: bool,
}

/// Most threads that go on reading pictures that were given up. A program could ask for more files than the machine can decode at once.
const MOST_GIVEN_UP: usize = 2;

struct Waiting {
    id: Value,
    /// An edit that did not come is refused then. Everything else has no deadline.
    until: Instant,
    awaits: Awaited,
}

/// What a request waits for.
enum Awaited {
    /// An edit.
    Edit,
    /// The file to open, at this project path.
    File(Later<ProjectFile>, String),
    /// The file at this project path runs, or has mistakes.
    Opening(String),
    /// A picture to keep, with the number of its request. The next request may give up one that is read from a file.
    Kept { kept: Later<Kept>, number: u64, from_file: bool },
    /// Figures of a comparison.
    Figures(Later<Value>),
    /// The end of the last frame, whose times are the answer.
    Times,
    /// The line of the answer.
    Line(Later<String>),
    /// This take is written.
    Take(Later<Value>, TakeIdentity),
    /// A search.
    Find(Box<Finding>),
}

impl Awaited {
    /// The time between two looks at it, without a window.
    fn pace(&self) -> Duration {
        Duration::from_millis(match self {
            Self::Edit | Self::Opening(_) => 20,
            _ => 1,
        })
    }

    /// Whether it may be there within the turn of a window.
    fn is_short(&self) -> bool {
        matches!(self, Self::Line(_) | Self::Find(_))
    }

    /// Whether files may be written meanwhile.
    fn writes(&self) -> bool {
        matches!(self, Self::Line(_) | Self::Take(..))
    }
}

/// The outcome of a look at the requests.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Next {
    /// The conversation goes on.
    More,
    /// The program sent `quit`.
    Quit,
}

impl Control {
    /// Listens to stdin. `wake` is called on another thread after each line.
    pub fn listen(drive: Drive, program: Program, wake: impl Fn() + Send + 'static) -> Self {
        let lines = lines::listen(BufReader::new(std::io::stdin()), wake);
        program.event(&json!({ "event": "ready", "protocol": request::PROTOCOL }));
        Self {
            lines,
            program,
            complained: false,
            drive,
            waiting: None,
            ahead: None,
            reading: Arc::default(),
            middle: None,
            diagnostics: Vec::new(),
            generation: 0,
            shown: 0,
        }
    }

    /// Answers requests that have come, without waiting: for a window. The others are answered after the frame.
    pub fn poll(&mut self, host: &mut dyn Host) -> Next {
        self.tire(host);
        let until = Instant::now() + TURN;
        // Requests are answered in their order, so a request that waits holds up the next. A window stays when the program has gone.
        while self.waiting.is_none()
            && self.program.has_room()
            && let Some(line) = self.next_line()
        {
            if self.line(line, host) == Next::Quit {
                return Next::Quit;
            }
            // A small read is there within the turn.
            while Instant::now() < until && self.waiting.as_ref().is_some_and(|waiting| waiting.awaits.is_short()) {
                std::thread::sleep(LOOK);
                self.tire(host);
            }
            if Instant::now() >= until {
                break;
            }
        }
        Next::More
    }

    /// Whether a window shall begin no frame before the last one has ended, since a request asks for its times.
    pub fn holds_frame(&self) -> bool {
        self.waiting.as_ref().is_some_and(|waiting| matches!(waiting.awaits, Awaited::Times))
    }

    /// Whether a request waits for its answer: [`Self::poll`] looks for it.
    pub fn awaits(&self) -> bool {
        self.waiting.is_some()
    }

    /// At the end of a window: waits for files that a request writes. Whether there are any: it looks, and waits no longer than a moment.
    pub fn is_writing(&mut self, host: &mut dyn Host) -> bool {
        if !self.waiting.as_ref().is_some_and(|waiting| waiting.awaits.writes()) {
            return false;
        }
        std::thread::sleep(LOOK);
        self.tire(host);
        true
    }

    /// A message about a program that does not read its answers, once.
    pub fn complaint(&mut self) -> Option<&'static str> {
        if self.complained || !self.program.reads_nothing() {
            return None;
        }
        self.complained = true;
        Some(
            "warning: the program does not read its answers. Its requests wait until it does, and events are left out: read stdout while \
             you send requests",
        )
    }

    /// Answers until the program quits, or closes its end.
    pub fn serve(&mut self, session: &mut Session) {
        let mut host = Alone::new(session);
        loop {
            let line = if let Some(waiting) = &self.waiting {
                let events = host.session().wait_reload(waiting.awaits.pace());
                self.note_alone(&events, &mut host);
                self.tire(&mut host);
                continue;
            } else if let Some(ahead) = self.ahead.take() {
                Ok(ahead.line)
            } else {
                self.lines.recv_timeout(Duration::from_millis(100))
            };
            let events = host.session().poll_reload();
            self.note_alone(&events, &mut host);
            let next = line.map(|line| self.line(line, &mut host));
            let said = host.session().take_messages();
            self.say(&said, host.session().texts());
            if matches!(next, Ok(Next::Quit) | Err(RecvTimeoutError::Disconnected)) {
                return;
            }
        }
    }

    /// Notes the events of a session without a window.
    fn note_alone(&mut self, events: &[ReloadEvent], host: &mut Alone<'_>) {
        for event in events {
            if let ReloadEvent::Reloaded(reloaded) = event {
                host.reloaded(reloaded.opened);
            }
            self.note(event);
        }
    }

    /// Reports a good or a broken edit as an event, and answers requests that wait for it.
    pub fn note(&mut self, event: &ReloadEvent) {
        let said = match event {
            ReloadEvent::Reloaded(reloaded) => {
                // Numbers of resources and passes are others now.
                self.middle = None;
                (self.generation, self.shown) = (reloaded.generation, reloaded.generation);
                self.diagnostics = parsed(&render::json(&reloaded.diagnostics, &reloaded.texts));
                json!({
                    "event": "reloaded",
                    "generation": reloaded.generation,
                    "changed": reloaded.changed,
                    "milliseconds": reloaded.milliseconds,
                })
            }
            ReloadEvent::Failed(failed) => {
                self.generation = failed.generation;
                self.diagnostics = parsed(&render::json(&failed.diagnostics, &failed.texts));
                json!({
                    "event": "reload-failed",
                    "generation": failed.generation,
                    "showing": self.shown,
                    "changed": failed.changed,
                })
            }
            ReloadEvent::NotOpened(error) => {
                if let OpenError::Project { diagnostics, texts } = error {
                    self.diagnostics = parsed(&render::json(diagnostics, texts));
                }
                return self.tell(false, &[]);
            }
            ReloadEvent::Opened => {
                self.diagnostics.clear();
                return self.tell(true, &[]);
            }
            ReloadEvent::HistoryCleared { size, resources } => {
                json!({ "event": "history-cleared", "size": size, "resources": resources })
            }
            ReloadEvent::DeviceRebuilt { suspect, off, milliseconds } => {
                json!({ "event": "device-rebuilt", "suspect": suspect, "off": off, "milliseconds": milliseconds })
            }
        };
        self.program.event(&said);
        match event {
            ReloadEvent::Reloaded(reloaded) => self.tell(true, &reloaded.changed),
            ReloadEvent::Failed(failed) => self.tell(false, &failed.changed),
            _ => {}
        }
    }

    /// Answers the request that waits for an edit of these files.
    fn tell(&mut self, reloaded: bool, changed: &[String]) {
        let answers = |waiting: &mut Waiting| match &waiting.awaits {
            Awaited::Edit => true,
            Awaited::Opening(path) => changed.contains(path),
            _ => false,
        };
        if let Some(waiting) = self.waiting.take_if(answers) {
            let told = self.told(if matches!(waiting.awaits, Awaited::Edit) { "reloaded" } else { "opened" }, reloaded);
            self.give(&waiting.id, Ok(told));
        }
    }

    /// The outcome of an edit.
    fn told(&self, word: &str, outcome: bool) -> Value {
        json!({ word: outcome, "generation": self.generation, "diagnostics": self.diagnostics })
    }

    /// Sends the session's messages as events.
    pub fn say(&self, said: &[Diagnostic], texts: &SourceMap) {
        for diagnostic in parsed(&render::json(said, texts)) {
            self.program.event(&json!({ "event": "diagnostic", "diagnostic": diagnostic }));
        }
    }

    /// Sends the prints of the frames of a request, before its answer.
    fn say_prints(&self, session: &mut Session) {
        // A window sends them frame by frame. If the device is lost, the next frame reports it.
        if self.drive == Drive::Requests && (!session.has_prints() || session.wait().is_ok()) {
            self.say_printed(&session.take_prints());
        }
    }

    /// Sends the prints of passes as events.
    pub fn say_printed(&self, printed: &[PassPrints]) {
        printed.iter().for_each(|prints| self.program.event(&prints::event(prints)));
    }

    /// The line that was read ahead, or the next one.
    fn next_line(&mut self) -> Option<Result<String, Refusal>> {
        self.ahead.take().map(|ahead| ahead.line).or_else(|| self.lines.try_recv().ok())
    }

    /// Whether the next request gives up a picture that is being kept. So does the end of the program's requests, but for a window.
    fn ends_keep(&mut self) -> bool {
        while self.ahead.is_none() {
            let line = match self.lines.try_recv() {
                Ok(line) => line,
                Err(TryRecvError::Disconnected) => return self.drive == Drive::Requests,
                Err(TryRecvError::Empty) => return false,
            };
            if line.as_ref().is_ok_and(|line| line.trim().is_empty()) {
                continue;
            }
            let request = line.as_ref().ok().and_then(|line| request::parse(line).1.ok());
            let is = |what: fn(&Request) -> bool| request.as_ref().is_some_and(what);
            let (ends_keep, quits) = (is(Request::ends_keep), is(|request| matches!(request, Request::Quit {})));
            self.ahead = Some(Ahead { line, ends_keep, quits });
        }
        // One clone is that of `self`, and one reads for the request that waits.
        let given_up = Arc::strong_count(&self.reading).saturating_sub(2);
        self.ahead.as_ref().is_some_and(|ahead| ahead.ends_keep && (ahead.quits || given_up < MOST_GIVEN_UP))
    }

    /// Answers with what has come, and gives up waiting for an edit that does not come.
    fn tire(&mut self, host: &mut dyn Host) {
        let Some(mut waiting) = self.waiting.take() else { return };
        let late = Instant::now() >= waiting.until;
        let answer = match &mut waiting.awaits {
            Awaited::Line(line) => match line.poll() {
                Some(Ok(line)) => return self.program.answer_line(line),
                refused => refused.map(|refused| refused.map(Value::from)),
            },
            Awaited::Find(finding) => finding.poll(host.session()),
            Awaited::Times => match host.session().wait_picture(Duration::ZERO) {
                Ok(Progress::Done) => Some(Ok(describe::times(host.session()))),
                Ok(Progress::Working { .. }) => None,
                Err(error) => Some(Err(error.into())),
            },
            Awaited::Figures(figures) => figures.poll(),
            Awaited::Take(later, take) => {
                let written = later.poll();
                if matches!(written, Some(Ok(_))) {
                    host.session().stop_recording_of(take);
                }
                written
            }
            Awaited::Kept { kept, number, from_file } => {
                let kept = match kept.poll() {
                    None if *from_file && self.ends_keep() => {
                        let help = vec!["wait for its answer before `keep`, `forget` or `quit`".to_owned()];
                        Some(Err(Refusal { error: "the next request gave it up".to_owned(), help }))
                    }
                    kept => kept,
                };
                kept.map(|kept| answer::keep(host, kept, *number))
            }
            Awaited::Edit if late => Some(Err(Refusal::new("no edit came in that time"))),
            Awaited::Opening(path) if late => {
                let help = vec!["the event `reloaded` or `reload-failed` comes once it is opened".to_owned()];
                Some(Err(Refusal { error: format!("`{path}` was not opened in that time"), help }))
            }
            Awaited::File(file, path) => match file.poll().map(|file| open(host.session(), file?)) {
                Some(Ok(())) => {
                    waiting.awaits = Awaited::Opening(std::mem::take(path));
                    None
                }
                Some(Err(refusal)) => Some(Err(refusal)),
                None => None,
            },
            Awaited::Edit | Awaited::Opening(_) => None,
        };
        match answer {
            Some(answer) => self.give(&waiting.id, answer),
            None => self.waiting = Some(waiting),
        }
    }

    /// Begins work on an answer, or does it if there is no window.
    fn begin(&mut self, id: Value, work: Work, host: &mut dyn Host) {
        let awaits = match (self.drive, work) {
            (Drive::Requests, Work::Answer(later)) => {
                return match later.into_line(id.clone()).finish(host.session()) {
                    Ok(line) => self.program.answer_line(line),
                    Err(refusal) => self.give(&id, Err(refusal)),
                };
            }
            (Drive::Requests, work) => return self.give(&id, work.finish(host.session())),
            (Drive::Window, Work::Answer(later)) => Awaited::Line(later.into_line(id.clone())),
            (Drive::Window, Work::Take(later, take)) => Awaited::Take(later, take),
            (Drive::Window, Work::Find(finding)) => Awaited::Find(finding),
        };
        self.wait(id, 0.0, awaits);
        // Its thread starts at once.
        self.tire(host);
    }

    fn wait(&mut self, id: Value, seconds: f64, awaits: Awaited) {
        self.waiting = Some(Waiting { id, until: Instant::now() + Duration::from_secs_f64(seconds), awaits });
    }

    fn give(&self, id: &Value, answer: Result<Value, Refusal>) {
        self.program.answer(&answer::line(id, answer));
    }

    fn line(&mut self, line: Result<String, Refusal>, host: &mut dyn Host) -> Next {
        let (id, request) = match line {
            Ok(line) if line.trim().is_empty() => return Next::More,
            Ok(line) => request::parse(&line),
            Err(refusal) => (Value::Null, Err(refusal)),
        };
        match request {
            Err(refusal) => self.give(&id, Err(refusal)),
            Ok(Request::Quit {}) => {
                self.give(&id, Ok(json!({})));
                return Next::Quit;
            }
            Ok(Request::WaitReload { after: Some(after), .. }) if self.generation > after => {
                self.give(&id, Ok(self.told("reloaded", self.generation == self.shown)));
            }
            Ok(Request::WaitReload { seconds, .. }) => self.wait(id, seconds, Awaited::Edit),
            Ok(Request::Diagnostics {}) => {
                let session = host.session();
                let (generation, shown) = (self.generation, (!session.is_waiting()).then_some(self.shown));
                // With the present counts of passes.
                let counted = parsed(&render::json(&session.counted(), session.texts()));
                let all: Vec<&Value> = self.diagnostics.iter().chain(&counted).collect();
                let found = json!({ "generation": generation, "showing": shown, "diagnostics": all });
                self.give(&id, Ok(found));
            }
            Ok(_) if host.session().is_waiting() => self.give(&id, Err(Refusal::nothing_runs())),
            Ok(Request::Open { path, seconds }) => {
                self.wait(id, seconds, Awaited::File(work::file(host.session(), &path), path));
                self.tire(host);
            }
            Ok(Request::Keep(wanted)) => match compare::keep(host.session(), &wanted, &self.reading) {
                Ok(kept) => {
                    let number = host.awaits_kept();
                    self.wait(id, 0.0, Awaited::Kept { kept, number, from_file: wanted.path.is_some() });
                    // Its thread starts at once.
                    self.tire(host);
                }
                Err(refusal) => self.give(&id, Err(refusal)),
            },
            Ok(Request::Measure {}) => match compare::measure(host) {
                Ok(figures) => self.wait(id, 0.0, Awaited::Figures(figures)),
                Err(refusal) => self.give(&id, Err(refusal)),
            },
            Ok(Request::Timings {}) => match describe::may_time(host.session()) {
                Err(refusal) => self.give(&id, Err(refusal)),
                Ok(()) if self.drive == Drive::Window => {
                    self.wait(id, 0.0, Awaited::Times);
                    self.tire(host);
                }
                Ok(()) => {
                    let waited = host.session().wait().map_err(Refusal::from);
                    let times = waited.map(|()| describe::times(host.session()));
                    self.give(&id, times);
                }
            },
            Ok(request) => {
                let request = match answer::begin(request, host, self.middle.as_ref()) {
                    Err(other) => *other,
                    Ok(begun) => {
                        match begun {
                            Ok(work) => self.begin(id, work, host),
                            Err(refusal) => self.give(&id, Err(refusal)),
                        }
                        return Next::More;
                    }
                };
                let leads_to_edit = request.leads_to_edit();
                let mut answer = answer::answer(request, host, self.drive, &mut self.middle);
                if let (true, Ok(answer)) = (leads_to_edit, &mut answer) {
                    // `wait_reload` waits for the one after it.
                    answer["generation"] = self.generation.into();
                }
                self.say_prints(host.session());
                self.give(&id, answer);
            }
        }
        Next::More
    }
}

/// Opens another file of the project in place of what runs.
fn open(session: &mut Session, file: ProjectFile) -> Result<(), Refusal> {
    if session.open_file(file) {
        Ok(())
    } else {
        Err(Refusal::new("files are not watched: nothing else can be opened"))
    }
}

/// Lines of JSON.
fn parsed(text: &str) -> Vec<Value> {
    text.lines().filter_map(|line| serde_json::from_str(line).ok()).collect()
}
