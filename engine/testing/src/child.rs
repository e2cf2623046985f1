//! Child processes of tests: each has a time limit, and none outlives its test.

use std::io::{BufReader, Read};
use std::process::{Child, Command, ExitStatus, Output, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::thread::JoinHandle;
use std::time::Duration;

use wait_timeout::ChildExt;

/// Time limit of a child: many times that of the slowest of them on two busy cores.
pub const LIMIT: Duration = Duration::from_secs(600);

/// Runs a command to its end and returns its output.
#[track_caller]
pub fn output(command: &mut Command) -> Output {
    let mut child = Running::start(command.stdout(Stdio::piped()).stderr(Stdio::piped()));
    let [stdout, stderr] = [read_all(child.0.stdout.take()), read_all(child.0.stderr.take())];
    let status = child.finish();
    let [stdout, stderr] = [stdout, stderr].map(|reader| reader.join().expect("it only reads"));
    Output { status, stdout, stderr }
}

/// Reads a pipe while the child runs: a child whose pipe is full waits.
pub fn read_all(pipe: Option<impl Read + Send + 'static>) -> JoinHandle<Vec<u8>> {
    std::thread::spawn(move || {
        let mut bytes = Vec::new();
        if let Some(mut pipe) = pipe {
            pipe.read_to_end(&mut bytes).expect("a pipe");
        }
        bytes
    })
}

/// The output of a child, piece by piece. A silent child keeps its test for [`LIMIT`] and no longer.
pub struct Said<T>(Receiver<T>);

impl<T: Send + 'static> Said<T> {
    /// `next` reads the next piece from the child's pipe; `None` at its end.
    pub fn by<R: Read + Send + 'static>(
        pipe: R,
        mut next: impl FnMut(&mut BufReader<R>) -> Option<T> + Send + 'static,
    ) -> Self {
        let (sender, receiver) = channel();
        let mut pipe = BufReader::new(pipe);
        // It ends with the pipe, or when the receiver is gone.
        std::thread::spawn(move || while next(&mut pipe).is_some_and(|piece| sender.send(piece).is_ok()) {});
        Self(receiver)
    }

    /// The next piece.
    #[track_caller]
    pub fn next(&self) -> T {
        self.0.recv_timeout(LIMIT).unwrap_or_else(|error| panic!("the child says no more: {error}"))
    }
}

impl<T> Said<T> {
    /// The next piece, unless it takes longer; the error is true if the child is silent, and false if its pipe has ended.
    pub fn within(&self, limit: Duration) -> Result<T, bool> {
        self.0.recv_timeout(limit).map_err(|error| error == RecvTimeoutError::Timeout)
    }

    /// All that is left, once the child has ended.
    #[track_caller]
    pub fn rest(&self) -> Vec<T> {
        let next = || match self.0.recv_timeout(LIMIT) {
            Ok(piece) => Some(piece),
            Err(RecvTimeoutError::Disconnected) => None,
            Err(RecvTimeoutError::Timeout) => panic!("the child's pipe does not end"),
        };
        std::iter::from_fn(next).collect()
    }
}

/// A line of a pipe; `None` at its end.
pub fn line(pipe: &mut impl std::io::BufRead) -> Option<String> {
    let mut line = String::new();
    pipe.read_line(&mut line).ok().filter(|bytes| *bytes > 0)?;
    Some(line)
}

/// A child process; it is killed when it is dropped.
pub struct Running(pub Child);

impl Running {
    /// Starts a command.
    #[track_caller]
    pub fn start(command: &mut Command) -> Self {
        Self(command.spawn().unwrap_or_else(|error| panic!("{}: {error}", command.get_program().display())))
    }

    /// Waits for its end, for no longer than [`LIMIT`].
    #[track_caller]
    pub fn finish(&mut self) -> ExitStatus {
        let ended = self.0.wait_timeout(LIMIT).expect("a child can be waited for");
        ended.unwrap_or_else(|| panic!("process {} has not ended within {} s", self.0.id(), LIMIT.as_secs()))
    }

    /// Sends it a signal by its name, such as `TERM`. The shell has a `kill` of its own, so that no package is needed.
    #[cfg(unix)]
    #[track_caller]
    pub fn signal(&self, name: &str) {
        let kill = format!("kill -s {name} {}", self.0.id());
        let told = Command::new("sh").args(["-c", &kill]).status().expect("a shell");
        assert!(told.success(), "{kill}");
    }

    /// Whether it has ended.
    pub fn ended(&mut self) -> bool {
        self.0.try_wait().expect("a child can be asked").is_some()
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}
