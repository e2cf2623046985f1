//! The threads of a streamer. A thread that ends early reports why.
//!
//! A panic in the source of tiles is the outcome of one job. A panic anywhere else, and a thread that cannot start, end the streamer: its
//! tiles may be half changed. A caller that waits for a thread then wakes up and gets the reason.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::thread::JoinHandle;

use super::{Shared, StreamError};

/// The work of a thread.
pub(super) type Run = Box<dyn FnOnce() + Send>;

/// Starts a thread with a name: [`spawn`], or a test's function.
pub(super) type Spawn<'s> = &'s dyn Fn(&str, Run) -> std::io::Result<JoinHandle<()>>;

/// Starts a thread of the system.
pub(super) fn spawn(name: &str, run: Run) -> std::io::Result<JoinHandle<()>> {
    if planted("spawn") {
        return Err(std::io::Error::other("a planted fault"));
    }
    std::thread::Builder::new().name(name.to_owned()).spawn(run)
}

/// Starts one of the streamer's threads. The streamer ends where it cannot start, panics, or returns before the streamer is dropped.
pub(super) fn start(
    shared: &Arc<Shared>,
    name: String,
    spawn: Spawn<'_>,
    run: impl FnOnce(&Arc<Shared>) + Send + 'static,
) -> Option<JoinHandle<()>> {
    let (of_thread, thread) = (shared.clone(), name.clone());
    let guarded = move || {
        let outcome = caught(|| run(&of_thread));
        if of_thread.stop.load(Ordering::Acquire) && outcome.is_ok() {
            return;
        }
        let reason = outcome.map_or_else(|panic| panic, |()| "it returned".to_owned());
        of_thread.end(StreamError::Ended { thread, reason });
    };
    match spawn(&name, Box::new(guarded)) {
        Ok(thread) => Some(thread),
        Err(error) => {
            shared.end(StreamError::NotStarted { thread: name, reason: error.to_string() });
            None
        }
    }
}

/// Runs code that may panic, and gives the words of the panic. State that the code shares must be whole at every panic, or not be used
/// after it.
pub(super) fn caught<T>(run: impl FnOnce() -> T) -> Result<T, String> {
    catch_unwind(AssertUnwindSafe(run)).map_err(|payload| format!("it panicked: {}", words(&*payload)))
}

fn words(payload: &(dyn Any + Send)) -> &str {
    let text = payload.downcast_ref::<&str>().copied();
    text.or_else(|| payload.downcast_ref::<String>().map(String::as_str)).unwrap_or("without a message")
}

/// Whether a test has planted a fault at a place, so that a user's view of a failing thread can be tested from outside. Builds for users
/// have no debug assertions, and nothing of this.
#[cfg(debug_assertions)]
pub(super) fn planted(place: &str) -> bool {
    std::env::var_os("RAXEL_FAULT_STREAM").is_some_and(|planted| planted == place)
}

#[cfg(not(debug_assertions))]
pub(super) fn planted(_: &str) -> bool {
    false
}

#[cfg(test)]
mod tests;
