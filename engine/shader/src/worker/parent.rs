//! The parent's part: children that wait for work, and the handling of one that does not come back.

use std::io::{self, Read};
use std::process::{Child, ChildStdin, Command, ExitStatus, Stdio};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError};
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

use super::protocol::{Order, Reply, read, write};
use super::{ARGUMENT, CompileLimits, ISOLATION, Isolation, MAX_WAIT};
use crate::front_end::{self, Include, Included, Job, Outcome};

/// Why a child did not finish a shader.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Stopped {
    /// It reached a limit of time.
    Time(CompileLimits),
    /// It reached the limit of memory.
    Memory(CompileLimits),
    /// It crashed, for example on a null pointer.
    Crash,
}

/// Idle children.
static IDLE: Mutex<Vec<Worker>> = Mutex::new(Vec::new());

/// Compiles in a child. `None` when there are no children: none are asked for, or the system starts none.
pub(crate) fn compile(job: &Job, include: &mut dyn FnMut(Include) -> Included) -> Option<Result<Outcome, Stopped>> {
    let isolation = ISOLATION.get()?;
    let mut worker = waiting().or_else(|| Worker::start(isolation).ok())?;
    let result = worker.compile(job, isolation.limits, include);
    if result.is_ok() {
        let most = std::thread::available_parallelism().map_or(1, usize::from);
        let mut idle = idle();
        if idle.len() < most {
            idle.push(worker);
        }
    }
    Some(result)
}

/// A child that has nothing to do, and has not been ended by something else meanwhile.
fn waiting() -> Option<Worker> {
    loop {
        let mut worker = idle().pop()?;
        if matches!(worker.child.try_wait(), Ok(None)) {
            return Some(worker);
        }
    }
}

fn idle() -> std::sync::MutexGuard<'static, Vec<Worker>> {
    // The list is whole after every operation, so a panic elsewhere does not spoil it.
    IDLE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A child and its pipes. It ends when it is dropped.
struct Worker {
    child: Child,
    orders: ChildStdin,
    /// From a thread that reads the child's stdout: a pipe has no reads with a limit of time.
    replies: Receiver<Reply>,
}

impl Worker {
    fn start(isolation: &Isolation) -> io::Result<Self> {
        let mut command = Command::new(&isolation.program);
        command.arg(ARGUMENT).stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        #[cfg(unix)]
        {
            // Ctrl-C in the terminal is the parent's to answer.
            std::os::unix::process::CommandExt::process_group(&mut command, 0);
        }
        let mut child = command.spawn()?;
        let (Some(orders), Some(mut stdout)) = (child.stdin.take(), child.stdout.take()) else {
            return Err(io::Error::other("a child without pipes"));
        };
        let (sender, replies) = mpsc::channel();
        let thread = std::thread::Builder::new().name("shader replies".to_owned());
        thread.spawn(move || {
            while let Ok(reply) = read(&mut stdout) {
                if sender.send(reply).is_err() {
                    return;
                }
            }
        })?;
        let worker = Self { child, orders, replies };
        match worker.replies.recv_timeout(MAX_WAIT) {
            Ok(Reply::Hello(version)) if version == front_end::VERSION => Ok(worker),
            _ => Err(io::Error::other("it is not a shader compiler of this version")),
        }
    }

    fn compile(
        &mut self,
        job: &Job,
        limits: CompileLimits,
        include: &mut dyn FnMut(Include) -> Included,
    ) -> Result<Outcome, Stopped> {
        let end = Instant::now() + MAX_WAIT;
        let mut order = Order::Compile(job.clone(), limits);
        loop {
            if write(&order, &mut self.orders).is_err() {
                return Err(self.stopped(limits));
            }
            match self.replies.recv_timeout(end.saturating_duration_since(Instant::now())) {
                Ok(Reply::Done(Outcome::OutOfMemory)) => return Err(Stopped::Memory(limits)),
                Ok(Reply::Done(outcome)) => return Ok(outcome),
                Ok(Reply::Include(asked)) => order = Order::Included(include(asked)),
                Err(RecvTimeoutError::Timeout) => return Err(Stopped::Time(limits)),
                Ok(Reply::Hello(_)) | Err(RecvTimeoutError::Disconnected) => return Err(self.stopped(limits)),
            }
        }
    }

    /// Why a child whose pipes are closed has ended.
    fn stopped(&mut self, limits: CompileLimits) -> Stopped {
        // One that closed them and still runs has nothing to say any more.
        let _ = self.child.kill();
        let status = self.child.wait();
        let mut said = String::new();
        if let Some(stderr) = self.child.stderr.take() {
            // Rust and C++ print their reason for giving up; an unreadable text is no reason.
            let _ = stderr.take(4096).read_to_string(&mut said);
        }
        if status.is_ok_and(out_of_time) {
            Stopped::Time(limits)
        } else if ["bad_alloc", "memory allocation of", "out of memory"].iter().any(|sign| said.contains(sign)) {
            Stopped::Memory(limits)
        } else {
            Stopped::Crash
        }
    }
}

impl Drop for Worker {
    fn drop(&mut self) {
        // Either fails when the child has ended already.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Whether the kernel ended a child for its processor time.
#[cfg(unix)]
fn out_of_time(status: ExitStatus) -> bool {
    std::os::unix::process::ExitStatusExt::signal(&status) == Some(rustix::process::Signal::XCPU.as_raw())
}

#[cfg(not(unix))]
fn out_of_time(_: ExitStatus) -> bool {
    false
}
