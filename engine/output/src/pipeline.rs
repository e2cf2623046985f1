//! From a frame to its file, beside the rendering: workers encode on all cores, and one writer puts the results in place in the order of
//! the frames. Just enough frames are on their way that no core waits. Handing over one more waits.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, Sender, SyncSender, channel, sync_channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use raxel_runtime::timeline::CaptionText;

use super::caption;
use super::coding::{Coding, Shot};
use super::place::Destination;
use crate::error::{OutputError, Result};

/// Encoders and a writer at work. Dropped unfinished, a film that is being made is given up; frames that are whole stay.
pub(crate) struct Pipeline {
    jobs: Option<Sender<Job>>,
    /// One for each frame on its way.
    permits: SyncSender<()>,
    workers: Vec<JoinHandle<()>>,
    writer: Option<JoinHandle<Result>>,
    next: u64,
    shared: Arc<Shared>,
}

/// Busy time of the stages.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Busy {
    /// Of all workers together.
    pub encode: Duration,
    /// Of the writer.
    pub write: Duration,
}

#[derive(Default)]
struct Shared {
    /// All frames were handed over, and none was given up.
    complete: AtomicBool,
    /// The writer has come to its end.
    failed: AtomicBool,
    /// Frames in place.
    written: AtomicU64,
    encode: AtomicU64,
    write: AtomicU64,
}

struct Job {
    /// Its turn: from 0, without gaps.
    turn: u64,
    frame: u64,
    shot: Shot,
    caption: Option<CaptionText>,
}

/// An encoded frame, or why there is none.
type Done = (u64, u64, Result<Vec<u8>>);

impl Pipeline {
    /// Starts `workers` encoders, one at least, that write to a place.
    ///
    /// # Errors
    /// When the system gives no more threads.
    pub(crate) fn start(coding: Coding, place: Destination, workers: usize) -> Result<Self> {
        let workers = workers.max(1);
        let (jobs, queue) = channel::<Job>();
        let (done, results) = channel::<Done>();
        // Each worker has one in hand and finds the next one waiting; the writer has one, too.
        let (permits, returned) = sync_channel(2 * workers + 1);
        let shared = Arc::new(Shared::default());
        let queue = Arc::new(Mutex::new(queue));
        let workers = (0..workers)
            .map(|_| {
                let (queue, done, shared) = (queue.clone(), done.clone(), shared.clone());
                named("encoder", move || encode_all(&queue, &done, coding, &shared))
            })
            .collect::<Result<_>>()?;
        let writer = Some(named("writer", {
            let shared = shared.clone();
            move || {
                let result = write_all(&results, &returned, place, &shared);
                shared.failed.store(result.is_err(), Ordering::Release);
                result
            }
        })?);
        Ok(Self { jobs: Some(jobs), permits, workers, writer, next: 0, shared })
    }

    /// Hands a frame over, with the caption of a displayed picture. Waits while too many are on their way.
    ///
    /// # Errors
    /// Why an earlier frame could not be encoded or written.
    pub(crate) fn push(&mut self, frame: u64, shot: Shot, caption: Option<CaptionText>) -> Result {
        let job = Job { turn: self.next, frame, shot, caption };
        self.next += 1;
        let taken = self.permits.send(()).is_ok() && self.jobs.as_ref().is_some_and(|jobs| jobs.send(job).is_ok());
        if taken { Ok(()) } else { self.end() }
    }

    /// Waits until nothing is on its way any more: all frames that were handed over are written, or one of them could not be.
    pub(crate) fn settle(&self) {
        while !self.shared.failed.load(Ordering::Acquire) && self.shared.written.load(Ordering::Acquire) < self.next {
            std::thread::park_timeout(Duration::from_micros(50));
        }
    }

    /// Waits until everything is in place.
    pub(crate) fn finish(mut self) -> Result<Busy> {
        self.shared.complete.store(true, Ordering::Release);
        self.end()?;
        let busy = |nanoseconds: &AtomicU64| Duration::from_nanos(nanoseconds.load(Ordering::Acquire));
        Ok(Busy { encode: busy(&self.shared.encode), write: busy(&self.shared.write) })
    }

    /// Lets all threads come to their end, and returns the writer's result.
    fn end(&mut self) -> Result {
        drop(self.jobs.take());
        for worker in self.workers.drain(..) {
            let _ = worker.join();
        }
        match self.writer.take().map(JoinHandle::join) {
            Some(Ok(result)) => result,
            Some(Err(_)) => Err(OutputError::new("the writer of frames has stopped")),
            None => Ok(()),
        }
    }
}

impl Drop for Pipeline {
    fn drop(&mut self) {
        let _ = self.end();
    }
}

/// A thread with a name, for traces.
fn named<T: Send + 'static>(name: &str, run: impl FnOnce() -> T + Send + 'static) -> Result<JoinHandle<T>> {
    let started = std::thread::Builder::new().name(name.to_owned()).spawn(run);
    started.map_err(|error| OutputError::new(format!("the system starts no thread for the {name} of frames: {error}")))
}

/// A worker: one frame after another, until no more come or the receiver is gone.
#[expect(clippy::cast_possible_truncation, reason = "2⁶⁴ nanoseconds are 584 years")]
fn encode_all(queue: &Mutex<Receiver<Job>>, done: &Sender<Done>, coding: Coding, shared: &Shared) {
    loop {
        let job = queue.lock().unwrap_or_else(PoisonError::into_inner).recv();
        let Ok(Job { turn, frame, mut shot, caption }) = job else { return };
        let start = Instant::now();
        if let (Shot::Picture(picture), Some(line)) = (&mut shot, &caption) {
            caption::draw(picture, line);
        }
        let span = tracing::trace_span!("encode", frame).entered();
        let coded = coding.encode(shot);
        drop(span);
        shared.encode.fetch_add(start.elapsed().as_nanos() as u64, Ordering::AcqRel);
        if done.send((turn, frame, coded)).is_err() {
            return;
        }
    }
}

/// The writer: takes results as they come, and writes them in turn.
#[expect(clippy::cast_possible_truncation, reason = "2⁶⁴ nanoseconds are 584 years")]
fn write_all(results: &Receiver<Done>, permits: &Receiver<()>, mut place: Destination, shared: &Shared) -> Result {
    let mut early = BTreeMap::new();
    let mut turn = 0;
    // Ends when the last worker does.
    for (of, frame, coded) in results {
        early.insert(of, (frame, coded));
        while let Some((frame, coded)) = early.remove(&turn) {
            let bytes = coded?;
            let start = Instant::now();
            tracing::trace_span!("write", frame).in_scope(|| place.write(frame, &bytes))?;
            shared.write.fetch_add(start.elapsed().as_nanos() as u64, Ordering::AcqRel);
            let _ = permits.recv();
            turn += 1;
            shared.written.store(turn, Ordering::Release);
        }
    }
    if shared.complete.load(Ordering::Acquire) { place.finish() } else { Ok(()) }
}

#[cfg(test)]
mod tests {
    use raxel_execute::Picture;

    use super::super::coding::PictureFormat;
    use super::super::png::Compression;
    use super::super::{Output, Pattern};
    use super::*;

    const CODING: Coding = Coding { kind: PictureFormat::Png, compression: Compression::Fast, quality: 90 };

    fn shot(value: u8) -> Shot {
        // Every other picture takes much longer than its neighbour.
        let side = if value.is_multiple_of(2) { 4 } else { 300 };
        Shot::Picture(Picture { width: side, height: side, rgba: vec![value; (side * side * 4) as usize] })
    }

    fn pattern(folder: &std::path::Path) -> Pattern {
        match Output::parse(folder.join("%03d.png").to_str().unwrap(), None).unwrap() {
            Output::Frames(_, pattern) => pattern,
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn frames_are_those_of_one_worker_and_in_order() {
        let folder = tempfile::tempdir().unwrap();
        for (name, workers) in [("one", 1), ("many", 7)] {
            let place = Destination::frames(&pattern(&folder.path().join(name)), 0).unwrap();
            let mut pipeline = Pipeline::start(CODING, place, workers).unwrap();
            for frame in 0..40 {
                pipeline.push(frame, shot(frame as u8), None).unwrap();
            }
            assert!(pipeline.finish().unwrap().encode > Duration::ZERO);
        }
        for frame in 0..40 {
            let read = |name: &str| std::fs::read(folder.path().join(format!("{name}/{frame:03}.png"))).unwrap();
            assert!(read("one") == read("many"), "frame {frame}");
        }
    }

    #[test]
    fn a_frame_that_cannot_be_written_is_said_and_those_before_it_stay() {
        let folder = tempfile::tempdir().unwrap();
        let place = Destination::frames(&pattern(folder.path()), 0).unwrap();
        std::fs::create_dir(folder.path().join("005.png")).unwrap();
        let mut pipeline = Pipeline::start(CODING, place, 3).unwrap();
        let pushed: Result = (0..1000).try_for_each(|frame| pipeline.push(frame, shot(frame as u8), None));
        let failure = pushed.and_then(|()| pipeline.finish().map(drop)).unwrap_err();
        assert!(failure.message.contains("005.png` cannot be written: it is a folder"));
        let files = std::fs::read_dir(folder.path()).unwrap().count();
        assert_eq!(files, 6, "five frames and the folder, nothing half made");
    }
}
