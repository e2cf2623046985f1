//! The program that drives a verb: it reads answers and events as lines of JSON from stdout.
//!
//! A window must not wait for a program that does not read. So a thread of its own writes to such a program, and the lines before it are
//! limited. While the queue is full, the window takes no more requests. It loses no answer, and leaves out events, which it counts.

use std::collections::VecDeque;
use std::fs::File;
use std::io::{self, Write};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use serde_json::{Value, json};

use crate::console;

/// The queue is full from this number of bytes on.
const FULL: usize = 1 << 20;

/// Bytes that are written at once: each piece that goes through shows that the program reads.
const PIECE: usize = 1 << 16;

/// A program that has read nothing for this long, though lines wait for it, does not read.
const PATIENCE: Duration = Duration::from_secs(5);

/// Where its lines go.
#[derive(Clone, Debug)]
pub enum Program {
    /// To stdout at once. The verb waits while the program does not read.
    AtOnce,
    /// Into a queue. The verb never waits.
    Queued(Arc<Queue>),
}

/// Lines that a thread writes.
#[derive(Debug)]
pub struct Queue {
    state: Mutex<State>,
    changed: Condvar,
}

#[derive(Debug)]
struct State {
    lines: VecDeque<String>,
    /// Bytes of the lines, and those that are left of the line that is being written.
    bytes: usize,
    /// Events that were left out.
    omitted: usize,
    /// When the program has read last, or the first line came into the empty queue.
    read: Instant,
}

impl Program {
    /// A program whose lines a new thread writes.
    pub fn queued() -> Self {
        let queue = Arc::new(Queue::new());
        let writer = Arc::clone(&queue);
        std::thread::spawn(move || {
            let Err(error) = own_stdout().and_then(|out| writer.write(out));
            console::unwritable(&error);
        });
        Self::Queued(queue)
    }

    /// Sends an answer.
    pub fn answer(&self, answer: &Value) {
        match self {
            Self::AtOnce => console::json(answer),
            Self::Queued(queue) => queue.push_answer(answer),
        }
    }

    /// Sends an answer whose line was made before, without its end.
    pub fn answer_line(&self, line: String) {
        match self {
            Self::AtOnce => console::data(&(line + "\n")),
            Self::Queued(queue) => queue.push_answer_line(line + "\n"),
        }
    }

    /// Sends an event, if there is room for it.
    pub fn event(&self, event: &Value) {
        match self {
            Self::AtOnce => console::json(event),
            Self::Queued(queue) => queue.push_event(event),
        }
    }

    /// Whether there is room for an answer. A request that is taken nevertheless is answered, too.
    pub fn has_room(&self) -> bool {
        match self {
            Self::AtOnce => true,
            Self::Queued(queue) => queue.state().bytes < FULL,
        }
    }

    /// Whether the queue is full, and the program has read nothing for [`PATIENCE`].
    pub fn reads_nothing(&self) -> bool {
        match self {
            Self::AtOnce => false,
            Self::Queued(queue) => {
                let state = queue.state();
                state.bytes >= FULL && state.read.elapsed() >= PATIENCE
            }
        }
    }

    /// Waits until all lines are written, for as long as the program reads.
    pub fn finish(&self) {
        if let Self::Queued(queue) = self {
            queue.finish();
        }
    }
}

impl Queue {
    fn new() -> Self {
        let state = State { lines: VecDeque::new(), bytes: 0, omitted: 0, read: Instant::now() };
        Self { state: Mutex::new(state), changed: Condvar::new() }
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn push_answer(&self, answer: &Value) {
        self.push_answer_line(format!("{answer}\n"));
    }

    fn push_answer_line(&self, line: String) {
        self.state().push(line);
        self.changed.notify_all();
    }

    fn push_event(&self, event: &Value) {
        let mut state = self.state();
        if state.bytes < FULL {
            state.push(format!("{event}\n"));
            self.changed.notify_all();
        } else {
            state.omitted += 1;
        }
    }

    /// Writes the lines as they come, until one cannot be written.
    fn write(&self, mut out: impl Write) -> io::Result<std::convert::Infallible> {
        loop {
            let waiting = self.changed.wait_while(self.state(), |state| state.lines.is_empty());
            let line = waiting.unwrap_or_else(PoisonError::into_inner).lines.pop_front().unwrap_or_default();
            for piece in line.as_bytes().chunks(PIECE) {
                out.write_all(piece)?;
                let mut state = self.state();
                state.bytes -= piece.len();
                state.read = Instant::now();
                self.changed.notify_all();
            }
        }
    }

    fn finish(&self) {
        let mut state = self.state();
        while state.bytes > 0 {
            let left = PATIENCE.saturating_sub(state.read.elapsed());
            if left.is_zero() {
                return;
            }
            state = self.changed.wait_timeout(state, left).unwrap_or_else(PoisonError::into_inner).0;
        }
    }
}

impl State {
    fn push(&mut self, line: String) {
        if self.bytes == 0 {
            self.read = Instant::now();
        }
        let omitted = if self.bytes < FULL { std::mem::take(&mut self.omitted) } else { 0 };
        let omitted = (omitted > 0).then(|| json!({ "event": "events-omitted", "count": omitted }));
        for line in omitted.map(|omitted| format!("{omitted}\n")).into_iter().chain([line]) {
            self.bytes += line.len();
            self.lines.push_back(line);
        }
    }
}

/// Stdout without its lock, which the end of the process takes. A write may never return.
#[cfg(unix)]
fn own_stdout() -> io::Result<File> {
    use std::os::fd::AsFd;
    io::stdout().as_fd().try_clone_to_owned().map(File::from)
}

/// Stdout without its lock, which the end of the process takes. A write may never return.
#[cfg(windows)]
fn own_stdout() -> io::Result<File> {
    use std::os::windows::io::AsHandle;
    io::stdout().as_handle().try_clone_to_owned().map(File::from)
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc::{Receiver, SyncSender, sync_channel};

    use super::*;

    /// A pipe without room: each write waits until its bytes are read.
    struct Pipe(SyncSender<Vec<u8>>);

    impl Write for Pipe {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            self.0.send(bytes.to_vec()).map_err(|_| io::ErrorKind::BrokenPipe)?;
            Ok(bytes.len())
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    fn queued() -> (Program, Receiver<Vec<u8>>) {
        let queue = Arc::new(Queue::new());
        let (sender, pipe) = sync_channel(0);
        let writer = Arc::clone(&queue);
        std::thread::spawn(move || writer.write(Pipe(sender)));
        (Program::Queued(queue), pipe)
    }

    /// The next line, which is shorter than a piece.
    fn next(pipe: &Receiver<Vec<u8>>) -> Value {
        serde_json::from_slice(&pipe.recv().unwrap()).unwrap()
    }

    #[test]
    fn no_answer_is_lost_and_events_are_counted_while_the_program_does_not_read() {
        let (program, pipe) = queued();
        let text = "x".repeat(PIECE / 2);
        let mut sent = 0;
        while program.has_room() {
            program.answer(&json!({ "id": sent, "text": text }));
            sent += 1;
        }
        for _ in 0..3 {
            program.event(&json!({ "event": "reloaded" }));
        }
        program.answer(&json!({ "id": sent }));
        for id in 0..=sent {
            assert_eq!(next(&pipe)["id"], json!(id));
        }
        program.event(&json!({ "event": "printed" }));
        assert_eq!(next(&pipe), json!({ "event": "events-omitted", "count": 3 }));
        assert_eq!(next(&pipe), json!({ "event": "printed" }));
        program.finish();
    }

    #[test]
    fn the_end_waits_for_a_program_that_reads() {
        let (program, pipe) = queued();
        (0..100).for_each(|id| program.answer(&json!({ "id": id })));
        let reader = std::thread::spawn(move || (0..100).map(|_| next(&pipe)).collect::<Vec<_>>());
        program.finish();
        assert_eq!(reader.join().unwrap().len(), 100);
        let Program::Queued(queue) = program else { unreachable!() };
        assert_eq!(queue.state().bytes, 0);
    }
}
