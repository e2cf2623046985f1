//! What passes print (`debugPrintfEXT`), and assertions of shaders that fail (`rx_assert`): an error that is said once, until it holds again.

use std::collections::VecDeque;

use raxel_diagnostics::{Diagnostic, codes};
use raxel_execute::{Assertion, PassPrints};
use raxel_shader::prints::Call;

use super::counter_warnings::GONE;

/// Lines that at most wait to be taken. A program that never asks loses the older ones.
const MOST_WAITING: usize = 65_536;

/// Frames whose prints may still come.
const MOST_FRAMES: usize = 8;

/// What the passes of a session have printed.
pub(super) struct Prints {
    /// The numbers that the executor and the session have for the newest frames.
    frames: VecDeque<(u64, u64)>,
    /// The first frame of the executor that is not of an earlier graph.
    since: u64,
    waiting: VecDeque<PassPrints>,
    waiting_lines: usize,
    /// What each pass has printed when it ran last.
    latest: Vec<PassPrints>,
    failing: Vec<Failing>,
}

/// An assertion that has failed.
struct Failing {
    pass: String,
    call: Call,
    /// How often in the last frame in which it failed.
    last: u32,
    /// The worst frame.
    worst: Failure,
    /// Frames since then in which it held.
    held: u32,
    said: bool,
}

/// An assertion in one frame.
struct Failure {
    /// How often it failed.
    count: u32,
    /// The invocation in which it failed first.
    first: Option<[u32; 3]>,
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

    /// Takes what a pass has printed in a frame.
    pub(super) fn note(&mut self, mut prints: PassPrints) {
        let executed = prints.frame;
        let known = self.frames.iter().rev().find(|(known, _)| *known == executed);
        prints.frame = known.map_or(executed, |(_, frame)| *frame);
        let assertions = std::mem::take(&mut prints.assertions);
        if executed >= self.since {
            for assertion in assertions {
                self.judge(&prints, assertion);
            }
            self.failing.retain(|failing| failing.held < GONE || !failing.said);
            self.latest.retain(|latest| latest.pass != prints.pass);
            if !prints.lines.is_empty() {
                self.latest.push(prints.clone());
            }
        }
        if prints.lines.is_empty() {
            return;
        }
        self.waiting_lines += prints.lines.len();
        self.waiting.push_back(prints);
        while self.waiting_lines > MOST_WAITING
            && let Some(lost) = self.waiting.pop_front()
        {
            self.waiting_lines -= lost.lines.len();
        }
    }

    fn judge(&mut self, of: &PassPrints, Assertion { call, failed, first }: Assertion) {
        let known = |failing: &&mut Failing| failing.pass == of.pass && failing.call == call;
        match (self.failing.iter_mut().find(known), failed) {
            (None, 0) => {}
            (Some(failing), 0) => failing.held += 1,
            (Some(failing), _) => {
                (failing.last, failing.held) = (failed, 0);
                if failed > failing.worst.count {
                    failing.worst = Failure { count: failed, first, frame: of.frame };
                }
            }
            (None, _) => {
                let worst = Failure { count: failed, first, frame: of.frame };
                self.failing.push(Failing { pass: of.pass.clone(), call, last: failed, worst, held: 0, said: false });
            }
        }
    }

    /// The assertions that were not said yet.
    pub(super) fn take_failed(&mut self) -> Vec<Diagnostic> {
        let say = |failing: &mut Failing| {
            let said = std::mem::replace(&mut failing.said, true);
            (!said).then(|| failing.diagnostic(failing.worst.count))
        };
        self.failing.iter_mut().filter_map(say).collect()
    }

    /// What waits to be taken.
    pub(super) fn take(&mut self) -> Vec<PassPrints> {
        self.waiting_lines = 0;
        std::mem::take(&mut self.waiting).into()
    }

    /// What each pass has printed when it ran last.
    pub(super) fn latest(&self) -> &[PassPrints] {
        &self.latest
    }

    /// Assertions that fail at the moment: each until it has held for [`GONE`] frames.
    pub(super) fn failing(&self) -> impl Iterator<Item = Diagnostic> {
        self.failing.iter().map(|failing| failing.diagnostic(failing.last))
    }

    /// Another graph, or another beginning: what fails then is said anew.
    pub(super) fn forget(&mut self) {
        self.failing.clear();
        self.latest.clear();
        self.since = self.frames.back().map_or(0, |(executed, _)| executed + 1);
    }
}

impl Failing {
    fn diagnostic(&self, count: u32) -> Diagnostic {
        let Failure { first, frame, .. } = self.worst;
        let invocations = if count == 1 { "invocation" } else { "invocations" };
        let message = format!("`{}` failed in pass `{}`: {count} {invocations}", self.call.text, self.pass);
        let diagnostic = Diagnostic::error(codes::session::ASSERTION_FAILED, message);
        let first = first.map_or_else(String::new, |[x, y, z]| format!("first in invocation ({x}, {y}, {z}) of "));
        let diagnostic = match &self.call.place {
            Some(place) => diagnostic.label(place.clone(), format!("{first}frame {frame}")),
            None => diagnostic.note(format!("{first}frame {frame}")),
        };
        diagnostic.note(format!("this is said once, until it has held for {GONE} frames"))
    }
}
