//! A thread beside the frame's: it works on the newest job, and drops older ones that it has not begun.

use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;

/// The thread, the job that it takes next, and its results.
pub(crate) struct Worker<Job, Done> {
    desk: Arc<Desk<Job>>,
    done: Receiver<Done>,
    thread: Option<JoinHandle<()>>,
}

struct Desk<Job> {
    next: Mutex<Next<Job>>,
    changed: Condvar,
}

struct Next<Job> {
    job: Option<Job>,
    closed: bool,
}

impl<Job: Send + 'static, Done: Send + 'static> Worker<Job, Done> {
    /// A thread that does `work` for each job that it takes. The work sends its results as they come.
    pub(crate) fn new(mut work: impl FnMut(Job, &Sender<Done>) + Send + 'static) -> Self {
        let desk = Arc::new(Desk { next: Mutex::new(Next { job: None, closed: false }), changed: Condvar::new() });
        let (send, done) = channel();
        let theirs = desk.clone();
        let thread = std::thread::spawn(move || {
            while let Some(job) = theirs.take() {
                work(job, &send);
            }
        });
        Self { desk, done, thread: Some(thread) }
    }

    /// Hands a job over. An older one that was not begun is dropped.
    pub(crate) fn ask(&self, job: Job) {
        self.desk.lock().job = Some(job);
        self.desk.changed.notify_one();
    }

    /// The next result, if there is one. Does not wait.
    pub(crate) fn done(&self) -> Option<Done> {
        self.done.try_recv().ok()
    }
}

impl<Job> Desk<Job> {
    fn lock(&self) -> MutexGuard<'_, Next<Job>> {
        // A job is whole or absent, whatever thread has panicked.
        self.next.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Waits for a job; `None` when there will be none.
    fn take(&self) -> Option<Job> {
        let waits = |next: &mut Next<Job>| next.job.is_none() && !next.closed;
        let mut next = self.changed.wait_while(self.lock(), waits).unwrap_or_else(PoisonError::into_inner);
        next.job.take().filter(|_| !next.closed)
    }
}

impl<Job, Done> Drop for Worker<Job, Done> {
    /// Waits for the job in hand: it may hold memory of a device that is closed next.
    fn drop(&mut self) {
        self.desk.lock().closed = true;
        self.desk.changed.notify_one();
        if let Some(thread) = self.thread.take() {
            // A panic of the thread was shown when it happened.
            let _ = thread.join();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_newest_job_is_done_and_older_ones_are_dropped() {
        let (begun, begins) = channel();
        let (go, gate) = channel::<()>();
        let worker = Worker::new(move |job: u32, done: &Sender<u32>| {
            begun.send(job).unwrap();
            gate.recv().unwrap();
            done.send(job).unwrap();
        });
        worker.ask(1);
        assert_eq!(begins.recv(), Ok(1));
        // The thread works; meanwhile three more jobs come.
        for job in 2..=4 {
            worker.ask(job);
        }
        assert_eq!(worker.done(), None, "asking does not wait");
        go.send(()).unwrap();
        assert_eq!((begins.recv(), worker.done()), (Ok(4), Some(1)));
        go.send(()).unwrap();
        drop(worker);
        assert!(begins.recv().is_err(), "and nothing is left");
    }
}
