//! Runs a session frame by frame. Reads each wanted frame back, and encodes and writes it while the next frames are rendered.

use std::collections::VecDeque;
use std::num::NonZero;
use std::ops::Range;
use std::sync::Arc;
use std::time::{Duration, Instant};

use raxel_execute::moment::{Fraction, Moment};
use raxel_execute::{Picture, ReadTicket, Texels};
use raxel_runtime::timeline::Demo;
use raxel_runtime::{ReadError, Session};

use super::coding::{Coding, Shot};
use super::pipeline::{Busy, Pipeline};
use super::place::Destination;
use super::supersample::{Sum, offset};
use crate::error::OutputError;

/// Most targets that can be read back in one frame.
pub const MOST_LAYERS: usize = 8;

/// The data that is read back.
#[derive(Clone, Debug)]
pub enum Layers {
    /// The displayed picture.
    Picture,
    /// Texels of targets, [`MOST_LAYERS`] at most.
    Targets(Vec<Layer>),
}

/// One mip and layer of a target.
#[derive(Clone, Debug)]
#[allow(clippy::struct_field_names, reason = "a layer of an image is one number of three that name it")]
pub struct Layer {
    /// Name of the target.
    pub resource: String,
    /// How many frames ago.
    pub age: u32,
    /// Mip.
    pub mip: u32,
    /// Array layer, or slice of a volume.
    pub layer: u32,
}

/// How rendering, read-back, encoding and writing overlap.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// All stages run at the same time.
    AtOnce,
    /// Each frame is on disk before the next one begins. For comparison with [`Mode::AtOnce`].
    OneByOne,
}

/// A job: which frames to run, and how to write them.
pub struct Shoot {
    /// Frames to run. The clock of the session stands before the first of them.
    pub run: Range<u64>,
    /// Frames to write, a part of `run`.
    pub wanted: Range<u64>,
    /// The data to read back of each frame.
    pub layers: Layers,
    /// The form of the written frames.
    pub coding: Coding,
    /// A demo whose captions are drawn into the pictures, and the seconds of each frame.
    pub captions: Option<(Arc<Demo>, Fraction)>,
    /// Number of pictures that are averaged for each frame.
    pub samples: u32,
    /// Number of frames of the same moment to run before each written frame, for graphs that average over time.
    pub settle: u32,
    /// How rendering, read-back, encoding and writing overlap.
    pub mode: Mode,
}

/// How long the stages took.
#[derive(Clone, Copy, Debug, Default)]
pub struct Stages {
    /// Number of written frames.
    pub frames: u64,
    /// Extent of the last frame in pixels.
    pub size: Option<[u32; 2]>,
    /// Time from the first frame to the last file.
    pub wall: Duration,
    /// Time of rendering, waits for the device included.
    pub render: Duration,
    /// Time of read-back: waiting for copies, and reading their bytes.
    pub read_back: Duration,
    /// Time of waiting for encoders and the writer.
    pub held_up: Duration,
    /// Busy time of the threads that encode and write.
    pub busy: Busy,
    /// Number of encoding threads.
    pub workers: usize,
}

impl Stages {
    /// Each stage, and the share of the time in which it was busy, 0 to 1. The stage with the largest share bounds the rate.
    pub fn shares(&self) -> [(&'static str, f64); 4] {
        let wall = self.wall.as_secs_f64().max(1e-9);
        [
            ("render", self.render.as_secs_f64() / wall),
            ("read back", self.read_back.as_secs_f64() / wall),
            ("encode", self.busy.encode.as_secs_f64() / wall / self.workers.max(1) as f64),
            ("write", self.busy.write.as_secs_f64() / wall),
        ]
    }

    /// The stage that bounds the rate.
    pub fn bound(&self) -> &'static str {
        self.shares().into_iter().max_by(|a, b| a.1.total_cmp(&b.1)).map_or("", |(stage, _)| stage)
    }
}

/// A frame on its way from the device.
enum Requested {
    Picture(ReadTicket<Picture>),
    Targets(Vec<(String, ReadTicket<Texels>)>),
}

impl Shoot {
    /// Runs the frames. `frame_of` runs one frame. raxel calls `each` after each frame. The caller chooses the error type, so that it can
    /// distinguish a lost device from a full disk.
    pub fn run<E: From<OutputError> + From<ReadError>>(
        &self,
        session: &mut Session,
        place: Destination,
        mut each: impl FnMut(&mut Session, u64) -> Result<(), E>,
        mut frame_of: impl FnMut(&mut Session) -> Result<(), E>,
    ) -> Result<Stages, E> {
        let start = Instant::now();
        let workers = match self.mode {
            Mode::AtOnce => std::thread::available_parallelism().map_or(1, NonZero::get),
            Mode::OneByOne => 1,
        };
        let mut stages = Stages { workers, ..Stages::default() };
        let mut pipeline = Pipeline::start(self.coding, place, workers)?;
        let mut ahead: VecDeque<(u64, Requested)> = VecDeque::new();
        for frame in self.run.clone() {
            let rendering = Instant::now();
            let wanted = self.wanted.contains(&frame);
            for _ in 0..if wanted { self.settle } else { 0 } {
                frame_of(session)?;
                session.again();
            }
            if wanted && self.samples > 1 {
                let shot = self.sampled(session, &mut frame_of)?;
                stages.render += rendering.elapsed();
                each(session, frame)?;
                self.hand_over(&mut pipeline, frame, shot, &mut stages)?;
                continue;
            }
            frame_of(session)?;
            if self.mode == Mode::OneByOne {
                session.wait().map_err(|error| OutputError::new(error.to_string()))?;
            }
            stages.render += rendering.elapsed();
            each(session, frame)?;
            if wanted {
                ahead.push_back((frame, self.layers.request(session)?));
            }
            while ahead.len() > self.frames_ahead() {
                let Some((frame, requested)) = ahead.pop_front() else { break };
                let reading = Instant::now();
                let shot = requested.redeem(session)?;
                stages.read_back += reading.elapsed();
                self.hand_over(&mut pipeline, frame, shot, &mut stages)?;
            }
        }
        for (frame, requested) in ahead {
            let reading = Instant::now();
            let shot = requested.redeem(session)?;
            stages.read_back += reading.elapsed();
            self.hand_over(&mut pipeline, frame, shot, &mut stages)?;
        }
        let ending = Instant::now();
        stages.busy = pipeline.finish()?;
        stages.held_up += ending.elapsed();
        stages.wall = start.elapsed();
        Ok(stages)
    }

    /// Frames that may be rendered before one is taken over from the device.
    fn frames_ahead(&self) -> usize {
        let layers = match &self.layers {
            Layers::Picture => 1,
            Layers::Targets(layers) => layers.len().max(1),
        };
        match self.mode {
            Mode::AtOnce => (MOST_LAYERS / layers).saturating_sub(1).min(2),
            Mode::OneByOne => 0,
        }
    }

    fn hand_over(
        &self,
        pipeline: &mut Pipeline,
        frame: u64,
        shot: Shot,
        stages: &mut Stages,
    ) -> Result<(), OutputError> {
        stages.frames += 1;
        stages.size = Some(shot.size());
        let waiting = Instant::now();
        let caption = self.captions.as_ref().and_then(|(demo, step)| demo.caption(Moment::of_frame(frame, *step)));
        pipeline.push(frame, shot, caption.cloned())?;
        if self.mode == Mode::OneByOne {
            pipeline.settle();
        }
        stages.held_up += waiting.elapsed();
        Ok(())
    }

    /// The average of several pictures of the next frame: its time and its index are the same in all of them.
    fn sampled<E: From<OutputError> + From<ReadError>>(
        &self,
        session: &mut Session,
        frame_of: &mut impl FnMut(&mut Session) -> Result<(), E>,
    ) -> Result<Shot, E> {
        let mut sum = Sum::default();
        let mut last = None;
        for sample in 0..self.samples {
            session.set_subpixel(offset(sample, self.samples));
            if sample > 0 {
                session.repeat();
            }
            frame_of(session)?;
            let shot = self.layers.request(session)?.redeem(session)?;
            sum.add(&shot)?;
            last = Some(shot);
        }
        session.set_subpixel([0.0; 2]);
        match last {
            Some(last) => Ok(sum.average(last)),
            None => Ok(self.layers.request(session)?.redeem(session)?),
        }
    }
}

impl Layers {
    fn request(&self, session: &mut Session) -> Result<Requested, ReadError> {
        match self {
            Layers::Picture => session.request_picture().map(Requested::Picture),
            Layers::Targets(layers) => {
                let request = |layer: &Layer| {
                    let ticket = session.request_texels(&layer.resource, layer.age, layer.mip, layer.layer)?;
                    Ok((layer.resource.clone(), ticket))
                };
                layers.iter().map(request).collect::<Result<_, _>>().map(Requested::Targets)
            }
        }
    }
}

impl Requested {
    fn redeem(self, session: &Session) -> Result<Shot, ReadError> {
        let _span = tracing::trace_span!("read back").entered();
        Ok(match self {
            Requested::Picture(ticket) => Shot::Picture(session.redeem(&ticket)?),
            Requested::Targets(tickets) => {
                let redeem = |(name, ticket)| Ok((name, session.redeem::<Texels>(&ticket)?));
                Shot::Texels(tickets.into_iter().map(redeem).collect::<Result<_, ReadError>>()?)
            }
        })
    }
}
