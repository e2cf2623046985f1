//! The numbers of a copied target, which another thread works out: a large target takes longer than a frame may.

use std::sync::Arc;
use std::sync::mpsc::Sender;
use std::time::{Duration, Instant};

use raxel_execute::{Captured, ReadTicket};
use raxel_panels::view::Shown;
use raxel_picture::{NotFinite, Statistics, not_finite};

use super::finding::{Look, Looked};
use super::worker::Worker;

/// The thread of an inspector.
pub(crate) type Numberer = Worker<Job, Done>;

/// What the thread is asked for.
pub(crate) enum Job {
    /// Reads a copy that has arrived, and works out its numbers.
    Read {
        /// The copied target.
        shown: Shown,
        /// The copy.
        ticket: ReadTicket<Captured>,
        /// Its number.
        number: u64,
        /// The channel of the statistics.
        channel: u32,
    },
    /// Works out the numbers of another channel of a copy.
    Channel {
        /// The copy.
        copy: Taken,
        /// The channel of the statistics.
        channel: u32,
    },
    /// Looks for a value in a slice.
    Look(Look),
}

/// What the thread has done.
pub(crate) enum Done {
    /// A copy was read.
    Copy(Taken),
    /// Its numbers, which end a job.
    Numbers(Box<Numbers>),
    /// The copy was lost with its device, which ends a job.
    Lost,
    /// A slice was looked at, which ends a job.
    Looked(Looked),
}

/// A copy of a target or a buffer.
#[derive(Clone)]
pub(crate) struct Taken {
    /// The copied target.
    pub shown: Shown,
    /// The contents.
    pub captured: Arc<Captured>,
    /// A later copy has a larger number.
    pub number: u64,
    /// When it was read.
    pub read: Instant,
}

/// The numbers of a copy.
pub(crate) struct Numbers {
    /// The copied target.
    pub shown: Shown,
    /// The number of the copy.
    pub number: u64,
    /// The channel of the statistics.
    pub channel: u32,
    /// `None` of a buffer.
    pub statistics: Option<Statistics>,
    /// Of each channel.
    pub not_finite: Vec<NotFinite>,
    /// The time that the thread took.
    pub took: Duration,
}

/// Starts the thread.
pub(crate) fn start() -> Numberer {
    // The thread keeps the copy that it has read last, so that the frame's thread does not free it: that takes a millisecond of a large one.
    let mut kept: Option<Taken> = None;
    Worker::new(move |job, done: &Sender<Done>| {
        let began = Instant::now();
        // The receiver may be gone, and nobody waits for the result then.
        let _ = match job {
            Job::Look(look) => done.send(Done::Looked(look.run())),
            Job::Channel { copy, channel } => done.send(Done::Numbers(numbers(&copy, channel, began))),
            Job::Read { shown, ticket, number, channel } => match ticket.poll() {
                Ok(Some(captured)) => {
                    let copy = Taken { shown, captured: Arc::new(captured), number, read: Instant::now() };
                    // Its values can be read before its statistics are there.
                    let _ = done.send(Done::Copy(copy.clone()));
                    let sent = done.send(Done::Numbers(numbers(&copy, channel, began)));
                    drop(kept.replace(copy));
                    sent
                }
                Ok(None) | Err(_) => done.send(Done::Lost),
            },
        };
    })
}

fn numbers(copy: &Taken, channel: u32, began: Instant) -> Box<Numbers> {
    let (statistics, not_finite) = match &*copy.captured {
        Captured::Texels(texels) => {
            let channels = texels.format.channels() as usize;
            let values = texels.floats();
            let counts = not_finite(&values, channels);
            let of = (channel as usize).min(channels - 1);
            (Statistics::of(values.into_iter().map(|texel| texel[of])), counts)
        }
        Captured::Bytes { .. } => (None, Vec::new()),
    };
    let (shown, number, took) = (copy.shown.clone(), copy.number, began.elapsed());
    Box::new(Numbers { shown, number, channel, statistics, not_finite, took })
}
