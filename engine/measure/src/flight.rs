//! A flight through a streamed world, against the same flight with everything there: `raxel bench stream`.

mod edits;
mod part;
mod passes;

use std::time::{Duration, Instant};

use raxel_diagnostics::{Diagnostic, SourceMap};
use raxel_execute::{FrameReport, Progress};
use raxel_runtime::camera::Camera;
use raxel_runtime::session::{FrameError, OpenError, Options, Session};
use raxel_stream::{PoolStats, Stats, ThreadTime};
use serde::Serialize;

pub use edits::{EditLatency, Edits, Rate, SeenIn};
pub use part::FlightPart;
pub use passes::Passes;

pub use crate::times::percentile;

use part::Path;

/// The settings of a flight.
#[derive(Clone)]
pub struct FlightOptions {
    /// How the session is opened. Its world is streamed.
    pub session: Options,
    /// Voxels a second of the straight parts.
    pub speed: f64,
    /// Seconds of each straight part.
    pub seconds: f64,
    /// Seconds of the way down, and at each place after a jump.
    pub stay: f64,
    /// Edits after the flight: this many small balls, and as many large ones, are put in view and taken away again. As many frames with
    /// edits of many chunks follow. The large balls and the frames have an upper limit.
    pub balls: u32,
    /// Whether the path is flown again with every place complete.
    pub resident: bool,
    /// Longest time until the first place is there, or an edit is seen.
    pub patience: Duration,
}

/// Why there is no result.
#[derive(Debug, thiserror::Error)]
pub enum FlightError {
    /// The project does not open.
    #[error(transparent)]
    Open(#[from] OpenError),
    /// A frame does not run.
    #[error(transparent)]
    Frame(#[from] FrameError),
    /// The world is whole, or no pass binds it.
    #[error("`{0}` is not streamed by this graph: there is nothing to measure")]
    NotStreamed(String),
    /// A place did not come.
    #[error("after {seconds} s, {missing} chunks around the camera are missing")]
    Unsettled {
        /// Seconds waited.
        seconds: u64,
        /// Tiles missing.
        missing: usize,
    },
    /// An edit did not come into view.
    #[error("after {seconds} s, an edit is not seen")]
    Unseen {
        /// Seconds waited.
        seconds: u64,
    },
}

/// The measurements of one frame.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Frame {
    /// Seconds since the flight began.
    pub time: f64,
    /// The part of the path that the camera is on.
    pub part: FlightPart,
    /// Seconds since that part began.
    pub since: f64,
    /// Milliseconds from the start of the frame to the end of its picture on the device.
    pub milliseconds: f64,
    /// Those of them until all of it was submitted.
    pub submitted: f64,
    /// Milliseconds from the begin of its first pass on the device to the end of its last. Nothing where the device has no clock, or no pass ran.
    pub device: Option<f64>,
    /// Milliseconds of each pass on the device, as [`Flown::passes`] names them; a pass that did not run has none, or 0.
    pub passes: Vec<f64>,
    /// Passes that ran: none where the picture is that of the frame before.
    pub dispatched: u32,
    /// Microseconds that the streamed world took on the thread of the frame.
    pub stream_microseconds: f64,
    /// Bytes written to the pool since the frame before.
    pub bytes: u64,
    /// Tiles made since the frame before.
    pub tiles: u64,
    /// Wanted tiles that are not there.
    pub missing: usize,
    /// Those of them that are chunks of single voxels and to be shown, as of the last publication.
    pub missing_chunks: usize,
    /// Tiles that are to be shown where the camera is, may be in the picture, and are not in the publication that the frame saw. Where a
    /// coarser one is there, that is seen.
    pub missing_in_view: usize,
    /// Those of them in whose place nothing is seen.
    pub holes_in_view: usize,
    /// Whether all of that is known of the place where the camera is, and not of the one before.
    #[serde(skip)]
    looked: bool,
    /// Whether the missing tiles in view are known.
    #[serde(skip)]
    known: bool,
}

/// All frames of a way of flying.
#[derive(Clone, Debug, Serialize)]
pub struct Flown {
    /// Names of the passes that ran; the rounds of a loop count together.
    pub passes: Vec<String>,
    /// Each frame.
    pub frames: Vec<Frame>,
    /// The state of the world at the end.
    #[serde(skip)]
    pub stats: Stats,
}

/// The result.
#[derive(Clone, Debug, Serialize)]
pub struct Flight {
    /// Name of the device.
    pub device: String,
    /// Extent of the output in pixels.
    pub size: [u32; 2],
    /// Seconds until the first place was there, from nothing.
    pub first_seconds: f64,
    /// The flight, with the world being loaded.
    pub live: Flown,
    /// Seconds from the start of the flight to the first jump to fresh land.
    pub jumps_at: f64,
    /// After each jump.
    pub jumps: Vec<Arrival>,
    /// Edits in view after the flight.
    pub edits: Edits,
    /// Memory that the host holds at the end of the flight.
    pub kept: Kept,
    /// The same path, every place complete before its frame: the difference is the cost of loading. Nothing if that was not asked for.
    pub resident: Flown,
    /// The pool at the end.
    #[serde(skip)]
    pub pool: PoolStats,
    /// Messages of the session that loaded, such as the counts of its passes, and the texts that they point into. The same path with
    /// everything there would say it again.
    #[serde(skip)]
    pub messages: (Vec<Diagnostic>, SourceMap),
}

/// Milliseconds from a jump to the end of a picture on the device; none where there was no such picture before the next jump.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Arrival {
    /// The first one without a hole: something is there in every place, if only coarse.
    pub whole: Option<f64>,
    /// The first one in which no tile in view is missing at its own level.
    pub complete: Option<f64>,
    /// The first one for which no chunk of single voxels is missing, wherever the camera may turn.
    pub chunks: Option<f64>,
    /// The first one for which no tile is missing at all.
    pub settled: Option<f64>,
}

/// Packed chunks on the host.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct Kept {
    /// Chunks.
    pub chunks: usize,
    /// Bytes that they take.
    pub bytes: u64,
    /// Bytes that they may take.
    pub most: u64,
    /// Chunks that were found there in place of being made.
    pub found: u64,
    /// Chunks that were made.
    pub made: u64,
}

impl Frame {
    /// Whether a pass ran.
    pub fn is_drawn(&self) -> bool {
        self.dispatched > 0
    }
}

impl Flown {
    /// The frames in which a pass ran. Other frames, while the camera stands still, take almost no time, and their number
    /// depends on the processor. So they say nothing about a flight.
    pub fn drawn(&self) -> impl Iterator<Item = &Frame> {
        self.frames.iter().filter(|frame| frame.is_drawn())
    }

    /// The value that `part` (0 to 1) of the drawn frames do not exceed: the nearest rank.
    pub fn percentile(&self, part: f64, of: impl Fn(&Frame) -> f64) -> f64 {
        percentile(self.drawn().map(of), part)
    }

    /// The frames that take longest, from the longest on.
    pub fn longest(&self, count: usize) -> Vec<&Frame> {
        let mut frames: Vec<&Frame> = self.frames.iter().collect();
        frames.sort_by(|a, b| b.milliseconds.total_cmp(&a.milliseconds));
        frames.truncate(count);
        frames
    }

    /// The parts of the path in the order in which they were flown, with the frames of each.
    pub fn parts(&self) -> Vec<(FlightPart, Vec<&Frame>)> {
        let mut parts: Vec<(FlightPart, Vec<&Frame>)> = Vec::new();
        for frame in &self.frames {
            match parts.last_mut().filter(|(part, _)| *part == frame.part) {
                Some((_, frames)) => frames.push(frame),
                None => parts.push((frame.part, vec![frame])),
            }
        }
        parts
    }

    /// Drawn frames that take longer than `times` times their median.
    pub fn over(&self, times: f64) -> usize {
        let limit = times * self.percentile(0.5, |frame| frame.milliseconds);
        self.drawn().filter(|frame| frame.milliseconds > limit).count()
    }
}

/// The arrival of each jump, from the frames.
fn arrivals(frames: &[Frame]) -> Vec<Arrival> {
    let jump = |n: u32| {
        let after = |is: fn(&Frame) -> bool| {
            let there = |frame: &&Frame| frame.part == FlightPart::Jump(n) && frame.looked && is(frame);
            frames.iter().find(there).map(|frame| frame.since * 1e3 + frame.milliseconds)
        };
        Arrival {
            whole: after(|frame| frame.holes_in_view == 0),
            complete: after(|frame| frame.missing_in_view == 0),
            chunks: after(|frame| frame.missing_chunks == 0),
            settled: after(|frame| frame.missing == 0),
        }
    };
    (1..=part::JUMPS).map(jump).collect()
}

/// A frame at a place that the streamer had not looked at yet gets the missing tiles of the next frame at a known place.
fn count_unknown(frames: &mut [Frame]) {
    let mut next = [0, 0];
    for frame in frames.iter_mut().rev() {
        if frame.known {
            next = [frame.missing_in_view, frame.holes_in_view];
        } else {
            [frame.missing_in_view, frame.holes_in_view] = next;
        }
    }
}

/// Flies.
pub fn fly(options: &FlightOptions) -> Result<Flight, FlightError> {
    let mut session = Session::open(Options { step: None, ..options.session.clone() })?;
    let began = Instant::now();
    settle(&mut session, options.patience)?;
    let first_seconds = began.elapsed().as_secs_f64();
    let first = *session.camera();
    let path = Path { first, speed: options.speed, leg: options.seconds, stay: options.stay };

    let started = Instant::now();
    let mut frames: Vec<Frame> = Vec::new();
    let mut passes = Passes::default();
    while started.elapsed().as_secs_f64() < path.length() {
        frames.push(flown(&mut session, &path, started.elapsed().as_secs_f64(), &mut passes)?);
    }
    count_unknown(&mut frames);
    let stats = session.stream().map(|stream| stream.stats()).unwrap_or_default();
    let kept = session.world().kept().unwrap_or_default();
    let edits = edits::measure(&mut session, options)?;
    let (device, size) = (session.device().capabilities().name.clone(), session.size());
    let messages = (session.take_messages(), session.texts().clone());
    drop(session);

    // The same moments: one frame for each.
    let step = Some(1.0 / 60.0);
    let mut session = Session::open(Options { step, ..options.session.clone() })?;
    session.set_camera(first);
    session.frame()?;
    session.wait()?;
    let times: Vec<f64> = frames.iter().map(|frame| frame.time).collect();
    let (mut resident, mut resident_passes) = (Vec::new(), Passes::default());
    for time in times.into_iter().filter(|_| options.resident) {
        resident.push(flown(&mut session, &path, time, &mut resident_passes)?);
    }
    count_unknown(&mut resident);
    let resident_stats = session.stream().map(|stream| stream.stats()).unwrap_or_default();
    Ok(Flight {
        device,
        size,
        first_seconds,
        pool: stats.pool,
        messages,
        jumps_at: path.first_jump(),
        jumps: arrivals(&frames),
        live: Flown { passes: passes.into_names(), frames, stats },
        edits,
        kept: Kept { chunks: kept.tiles, bytes: kept.bytes, most: kept.capacity, found: kept.hits, made: kept.misses },
        resident: Flown { passes: resident_passes.into_names(), frames: resident, stats: resident_stats },
    })
}

/// Waits until all that the camera wants is there and shown.
fn settle(session: &mut Session, patience: Duration) -> Result<(), FlightError> {
    let began = Instant::now();
    loop {
        loaded_frame(session)?;
        let Some(stream) = session.stream() else {
            let whose = session.world().path.clone().unwrap_or_default();
            return Err(FlightError::NotStreamed(whose));
        };
        if stream.is_settled() && !stream.has_news() {
            // The rest of the device's work for these frames is no part of the next one.
            return session.wait().map_err(FlightError::Frame);
        }
        if began.elapsed() > patience {
            let missing = stream.stats().missing;
            return Err(FlightError::Unsettled { seconds: patience.as_secs(), missing });
        }
        std::thread::sleep(Duration::from_millis(1));
    }
}

/// Runs the frame of a moment of the path to its end, with the times of its passes.
fn flown(session: &mut Session, path: &Path, time: f64, passes: &mut Passes) -> Result<Frame, FrameError> {
    let (part, since) = path.part(time);
    let frame = one(session, path.camera(time))?;
    let (device, passes) = passes.take(session);
    Ok(Frame { time, part, since, device, passes, ..frame })
}

/// A frame of a world that is still loaded: nothing more can be measured, or waited for, once it is not.
fn loaded_frame(session: &mut Session) -> Result<FrameReport, FrameError> {
    let report = session.frame()?;
    match session.stream().and_then(|stream| stream.stopped()) {
        Some(stopped) => Err(FrameError::Plan { diagnostics: vec![stopped], texts: Box::new(session.texts().clone()) }),
        None => Ok(report),
    }
}

/// Runs a frame to its end.
fn one(session: &mut Session, camera: Camera) -> Result<Frame, FrameError> {
    session.set_camera(camera);
    let before = session.stream().map(|stream| stream.stats()).unwrap_or_default();
    let began = Instant::now();
    let dispatched = loaded_frame(session)?.dispatched;
    let submitted = began.elapsed();
    while session.wait_picture(Duration::from_secs(1))? != Progress::Done {}
    let whole = began.elapsed();
    let Some(stream) = session.stream() else { return Ok(Frame::default()) };
    // The question whether it has looked comes first: the counts that follow are then of this place.
    let looked = stream.has_looked();
    let (stats, missing) = (stream.stats(), stream.missing_in_view());
    let ThreadTime { spent, waited } = stream.frame_time();
    // The wait for a complete world is not part of a frame's time.
    let milliseconds = |time: Duration| time.saturating_sub(waited).as_secs_f64() * 1e3;
    Ok(Frame {
        milliseconds: milliseconds(whole),
        submitted: milliseconds(submitted),
        dispatched,
        stream_microseconds: spent.as_secs_f64() * 1e6,
        bytes: stats.written.saturating_sub(before.written),
        tiles: stats.made.saturating_sub(before.made),
        missing: stats.missing,
        missing_chunks: if stats.missing == 0 { 0 } else { stats.missing_chunks.min(stats.missing) },
        missing_in_view: missing.unwrap_or_default().tiles,
        holes_in_view: missing.unwrap_or_default().holes,
        looked: looked && missing.is_some(),
        known: missing.is_some(),
        ..Frame::default()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arrivals_are_counted_from_the_jump_to_the_end_of_the_picture() {
        // Legs of 5 s: the jumps are after 11.5, 12.5 and 13.5 s.
        let path = Path { first: Camera::at([0.5; 3]), speed: 64.0, leg: 5.0, stay: 1.0 };
        let frame = |time, looked, holes_in_view, missing_in_view| Frame {
            part: path.part(time).0,
            since: path.part(time).1,
            milliseconds: 10.0,
            looked,
            holes_in_view,
            missing_in_view,
            missing: missing_in_view,
            missing_chunks: missing_in_view,
            ..Frame::default()
        };
        let mut frames = [
            frame(11.4, true, 0, 0),
            frame(11.52, false, 0, 0),
            frame(11.6, true, 2, 9),
            frame(11.75, true, 0, 5),
            frame(12.25, true, 0, 0),
            frame(12.75, true, 0, 1),
            frame(13.75, true, 1, 1),
        ];
        let rounded = |time: Option<f64>| time.map(|time| time.round() as i64);
        let jumps = arrivals(&frames);
        let found = jumps.iter().map(|jump| (rounded(jump.whole), rounded(jump.complete)));
        assert_eq!(found.collect::<Vec<_>>(), [(Some(260), Some(760)), (Some(260), None), (None, None)]);
        let settled = jumps.iter().map(|jump| rounded(jump.settled));
        assert_eq!(settled.collect::<Vec<_>>(), [Some(760), None, None]);
        // Something coarse is missing behind the camera.
        frames[4].missing = 3;
        let jumps = arrivals(&frames);
        let [jump, ..] = &jumps[..] else { unreachable!("there are three") };
        assert_eq!((rounded(jump.complete), rounded(jump.chunks), jump.settled), (Some(760), Some(760), None));
    }

    #[test]
    fn a_frame_whose_place_is_unknown_misses_what_the_next_one_does() {
        let frame = |known, missing_in_view| Frame { missing_in_view, known, ..Frame::default() };
        let mut frames = [(true, 0), (false, 0), (false, 0), (true, 5), (true, 1), (true, 0), (false, 0)]
            .map(|(known, missing)| frame(known, missing));
        count_unknown(&mut frames);
        assert_eq!(frames.map(|frame| frame.missing_in_view), [0, 5, 5, 5, 1, 0, 0]);
    }

    #[test]
    fn frames_are_told_apart_by_the_part_of_the_path() {
        let path = Path { first: Camera::at([0.5; 3]), speed: 64.0, leg: 2.0, stay: 1.0 };
        let frame = |time| Frame { time, part: path.part(time).0, ..Frame::default() };
        let frames = [0.1, 1.9, 2.1, 2.6, 5.0, 5.6, 6.7, 6.8, 9.0].map(frame).to_vec();
        let flown = Flown { passes: Vec::new(), frames, stats: Stats::default() };
        let found = flown.parts().into_iter().map(|(part, frames)| (part.to_string(), frames.len()));
        let parts =
            [("straight", 2), ("turn", 1), ("back", 1), ("down", 1), ("jump 1", 1), ("jump 2", 2), ("jump 3", 1)];
        assert_eq!(found.collect::<Vec<_>>(), parts.map(|(name, count)| (name.to_owned(), count)));
    }

    #[test]
    fn slow_frames_are_counted_against_the_median() {
        let frame = |milliseconds| Frame { milliseconds, dispatched: 1, ..Frame::default() };
        let mut frames = [1.0, 1.0, 1.0, 1.6, 2.1].map(frame).to_vec();
        // Frames without a draw are no part of it, whatever their number.
        frames.extend(vec![Frame { milliseconds: 0.01, ..Frame::default() }; 100]);
        let flown = Flown { passes: Vec::new(), frames, stats: Stats::default() };
        assert_eq!((flown.over(1.5), flown.over(2.0)), (2, 1));
        assert_eq!(flown.longest(2).iter().map(|frame| frame.milliseconds).collect::<Vec<_>>(), [2.1, 1.6]);
        assert!((flown.percentile(0.99, |frame| frame.milliseconds) - 2.1).abs() < 1e-12);
    }
}
