//! Prints of passes (`debugPrintfEXT`), assertions of shaders that fail (`rx_assert`), and accesses out of bounds: each an error that is
//! reported once, until it is gone.

use std::collections::VecDeque;

use raxel_diagnostics::{Diagnostic, Span, codes};
use raxel_execute::{PassPrints, PassWrites};
use raxel_shader::prints::{Access, Call};

use super::counter_warnings::GONE;

/// Lines that at most wait to be taken. A program that never asks loses the older ones.
const MOST_WAITING: usize = 65_536;

/// Frames whose prints may still come.
const MOST_FRAMES: usize = 8;

/// The prints of the passes of a session.
pub(super) struct Prints {
    /// The numbers that the executor and the session have for the newest frames.
    frames: VecDeque<(u64, u64)>,
    /// The first frame of the executor that is not of an earlier graph.
    since: u64,
    waiting: VecDeque<PassPrints>,
    waiting_lines: usize,
    /// The prints of each pass when it ran last.
    latest: Vec<PassPrints>,
    failing: Vec<Failing>,
}

/// A line of a shader that has failed.
struct Failing {
    pass: String,
    what: Failed,
    /// The number of failures in the last frame with a failure.
    last: u32,
    /// The worst frame.
    worst: Failure,
    /// Frames without a failure since then.
    held: u32,
    said: bool,
}

/// Things that can fail.
#[derive(Clone, PartialEq)]
enum Failed {
    Assertion(Call),
    Access(Access),
}

/// A failure in one frame.
struct Failure {
    /// The number of its failures.
    count: u32,
    /// The invocation of its first failure.
    first: Option<[u32; 3]>,
    /// The place of an access out of bounds.
    beyond: Option<String>,
    frame: u64,
}

impl Default for Prints {
    fn default() -> Self {
        // A frame takes no memory.
        let frames = VecDeque::with_capacity(MOST_FRAMES);
        Self { frames, since: 0, waiting: VecDeque::new(), waiting_lines: 0, latest: Vec::new(), failing: Vec::new() }
    }
}

impl Prints {
    /// A frame of the executor began, and the session's number of it.
    pub(super) fn begin(&mut self, executed: u64, frame: u64) {
        if self.frames.back().is_some_and(|(last, _)| executed <= *last) {
            // Another executor, after the device was lost, counts from 0 again.
            self.frames.clear();
            self.since = 0;
        }
        if self.frames.len() == MOST_FRAMES {
            self.frames.pop_front();
        }
        self.frames.push_back((executed, frame));
    }

    /// Takes the prints of a pass in a frame. Returns its writes of a texel, if it is of the present graph.
    pub(super) fn note(&mut self, mut prints: PassPrints) -> Option<PassWrites> {
        let executed = prints.frame;
        let known = self.frames.iter().rev().find(|(known, _)| *known == executed);
        prints.frame = known.map_or(executed, |(_, frame)| *frame);
        let assertions = std::mem::take(&mut prints.assertions);
        let out_of_bounds = std::mem::take(&mut prints.out_of_bounds);
        let written = prints.written.take().filter(|_| executed >= self.since);
        let written = written.map(|written| PassWrites { frame: prints.frame, ..written });
        if executed >= self.since {
            let frame = prints.frame;
            for failing in self.failing.iter_mut().filter(|failing| failing.pass == prints.pass) {
                failing.held += 1;
            }
            for found in assertions.into_iter().filter(|assertion| assertion.failed > 0) {
                let failure = Failure { count: found.failed, first: found.first, beyond: None, frame };
                self.judge(&prints.pass, Failed::Assertion(found.call), failure);
            }
            for (access, found) in out_of_bounds {
                let (first, beyond) = (Some(found.invocation), Some(found.beyond));
                let failure = Failure { count: found.count, first, beyond, frame };
                self.judge(&prints.pass, Failed::Access(access), failure);
            }
            self.failing.retain(|failing| failing.held < GONE || !failing.said);
            self.latest.retain(|latest| latest.pass != prints.pass);
            if !prints.lines.is_empty() {
                self.latest.push(prints.clone());
            }
        }
        if prints.lines.is_empty() {
            return written;
        }
        self.waiting_lines += prints.lines.len();
        self.waiting.push_back(prints);
        while self.waiting_lines > MOST_WAITING
            && let Some(lost) = self.waiting.pop_front()
        {
            self.waiting_lines -= lost.lines.len();
        }
        written
    }

    fn judge(&mut self, pass: &str, what: Failed, failure: Failure) {
        let last = failure.count;
        let known = self.failing.iter_mut().find(|failing| failing.pass == pass && failing.what == what);
        if let Some(failing) = known {
            (failing.last, failing.held) = (last, 0);
            if last > failing.worst.count {
                failing.worst = failure;
            }
        } else {
            let pass = pass.to_owned();
            self.failing.push(Failing { pass, what, last, worst: failure, held: 0, said: false });
        }
    }

    /// Failures that were not reported yet.
    pub(super) fn take_failed(&mut self) -> Vec<Diagnostic> {
        let say = |failing: &mut Failing| {
            let said = std::mem::replace(&mut failing.said, true);
            (!said).then(|| failing.diagnostic(failing.worst.count))
        };
        self.failing.iter_mut().filter_map(say).collect()
    }

    /// The waiting prints.
    pub(super) fn take(&mut self) -> Vec<PassPrints> {
        self.waiting_lines = 0;
        std::mem::take(&mut self.waiting).into()
    }

    /// The prints of each pass when it ran last.
    pub(super) fn latest(&self) -> &[PassPrints] {
        &self.latest
    }

    /// Assertions that fail and accesses that are out of bounds at the moment: each until it has held for [`GONE`] frames.
    pub(super) fn failing(&self) -> impl Iterator<Item = Diagnostic> {
        self.failing.iter().map(|failing| failing.diagnostic(failing.last))
    }

    /// Another graph runs, or the session starts over: assertions that still fail are reported again.
    pub(super) fn forget(&mut self) {
        self.failing.clear();
        self.latest.clear();
        self.since = self.frames.back().map_or(0, |(executed, _)| executed + 1);
    }
}

impl Failing {
    fn diagnostic(&self, count: u32) -> Diagnostic {
        let Failure { first, beyond, frame, .. } = &self.worst;
        let invocations = if count == 1 { "invocation" } else { "invocations" };
        let (code, message) = match &self.what {
            Failed::Assertion(call) => (
                codes::session::ASSERTION_FAILED,
                format!("`{}` failed in pass `{}`: {count} {invocations}", call.text, self.pass),
            ),
            Failed::Access(access) => {
                let name = if access.name.is_empty() { "an array".to_owned() } else { format!("`{}`", access.name) };
                let accesses = match (access.writes, count) {
                    (true, 1) => "write",
                    (true, _) => "writes",
                    (false, 1) => "read",
                    (false, _) => "reads",
                };
                let message = format!("{name} is accessed out of bounds in pass `{}`: {count} {accesses}", self.pass);
                (codes::session::OUT_OF_BOUNDS, message)
            }
        };
        let beyond = beyond.as_ref().map_or_else(String::new, |beyond| format!("{beyond}, "));
        let first = first.map_or_else(String::new, |[x, y, z]| format!("first in invocation ({x}, {y}, {z}) of "));
        let seen = format!("{beyond}{first}frame {frame}");
        let diagnostic = Diagnostic::error(code, message);
        let diagnostic = match self.what.place() {
            Some(place) => diagnostic.label(place.clone(), seen),
            None => diagnostic.note(seen),
        };
        diagnostic.note(format!("raxel repeats this error only after it has held for {GONE} frames"))
    }
}

impl Failed {
    fn place(&self) -> Option<&Span> {
        match self {
            Failed::Assertion(call) => call.place.as_ref(),
            Failed::Access(access) => access.place.as_ref(),
        }
    }
}
