//! Child processes of tests: each has a time limit, and none outlives its test.

use std::io::Read;
use std::process::{Child, Command, ExitStatus, Output, Stdio};
use std::thread::JoinHandle;
use std::time::Duration;

use wait_timeout::ChildExt;

/// How long a child may take: many times what the slowest of them needs on two busy cores.
const LIMIT: Duration = Duration::from_secs(600);

/// Runs a command to its end and gives what it wrote.
#[track_caller]
pub fn output(command: &mut Command) -> Output {
    let mut child = Running::start(command.stdout(Stdio::piped()).stderr(Stdio::piped()));
    let [stdout, stderr] = [read(child.0.stdout.take()), read(child.0.stderr.take())];
    let status = child.finish();
    let [stdout, stderr] = [stdout, stderr].map(|reader| reader.join().expect("it only reads"));
    Output { status, stdout, stderr }
}

/// Reads a pipe while the child runs: a child whose pipe is full waits.
fn read(pipe: Option<impl Read + Send + 'static>) -> JoinHandle<Vec<u8>> {
    std::thread::spawn(move || {
        let mut bytes = Vec::new();
        if let Some(mut pipe) = pipe {
            pipe.read_to_end(&mut bytes).expect("a pipe");
        }
        bytes
    })
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
