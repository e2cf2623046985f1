//! Film against settled: a frame of a film beside the picture that the same moment becomes when everything stands still.
//!
//! For each moment, the demo runs from its last cut. Its frame there is the film's. Then more frames of the same moment follow: first some, as after
//! a stop, then enough to settle. FLIP compares the first two with the last. The pictures are those of `raxel render DEMO --at T`, without and with
//! `--settle`.

use std::path::PathBuf;

use raxel_diagnostics::{Diagnostic, SourceMap};
use raxel_execute::moment::{Fraction, Moment};
use raxel_gpu::Validation;
use raxel_picture::{Encoding, Picture, compare};
use raxel_runtime::timeline::Demo;
use raxel_runtime::{FrameError, Observe, OpenError, Options, ReadError, Session};
use serde::Serialize;

use super::DeviceName;

/// The settings of a film.
#[derive(Clone, Debug)]
pub struct FilmOptions {
    /// A folder of the project.
    pub project: PathBuf,
    /// The demo's file.
    pub demo: PathBuf,
    /// A graph in place of the demo's own.
    pub graph: Option<String>,
    /// Params in place of the demo's and the graph's, as texts.
    pub set: Vec<(String, String)>,
    /// The Vulkan device: a part of its name, or its number.
    pub device: Option<String>,
    /// Whether the validation layer looks on.
    pub validation: Validation,
    /// Extent of the pictures in pixels.
    pub size: [u32; 2],
    /// Frames a second.
    pub fps: f64,
    /// Seconds from one moment to the next.
    pub every: f64,
    /// Frames of a moment until it counts as settled.
    pub settle: u32,
    /// Frames of a moment after which a stop is looked at.
    pub stop: u32,
}

/// One moment of a film.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Compared {
    /// Seconds from the start.
    pub second: f64,
    /// Number of the frame.
    pub frame: u64,
    /// Mean FLIP of the frame of the film against the settled picture.
    pub film: f64,
    /// The same of the picture some frames after a stop.
    pub stopped: f64,
    /// Mean of the displayed numbers of the film's frame over that of the settled picture, less 1: light that is lost or too much.
    pub brightness: f64,
}

/// All moments of a film by one graph.
#[derive(Clone, Debug)]
pub struct Filmed {
    /// Project path of the graph.
    pub graph: String,
    /// Name and driver of the device.
    pub device: DeviceName,
    /// The moments, in order.
    pub moments: Vec<Compared>,
    /// Messages of the session, and the texts that they point into.
    pub messages: (Vec<Diagnostic>, SourceMap),
    /// Messages of the validation layer.
    pub complaints: Vec<String>,
}

/// A number over the moments of a film.
#[derive(Clone, Copy, Debug)]
pub struct WorstAndMean {
    /// The value with the largest magnitude.
    pub worst: f64,
    /// The mean.
    pub mean: f64,
}

impl Filmed {
    /// The worst value and the mean of a number over the moments.
    pub fn worst_and_mean(&self, of: impl Fn(&Compared) -> f64) -> WorstAndMean {
        let values: Vec<f64> = self.moments.iter().map(of).collect();
        let worst = values.iter().fold(0.0, |worst: f64, value| if value.abs() > worst.abs() { *value } else { worst });
        WorstAndMean { worst, mean: values.iter().sum::<f64>() / values.len().max(1) as f64 }
    }
}

/// Why a film cannot be judged.
#[derive(Debug, thiserror::Error)]
pub enum FilmError {
    /// It does not open.
    #[error(transparent)]
    Open(#[from] OpenError),
    /// A frame does not run.
    #[error(transparent)]
    Frame(#[from] FrameError),
    /// A picture cannot be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// A param cannot be set.
    #[error(transparent)]
    Set(#[from] raxel_runtime::params::SetError),
    /// Nothing changes over the time of the demo, so each frame equals its settled picture.
    #[error("nothing changes over the time of the demo: it has no camera keys, tracks, inputs or edits")]
    Still,
    /// There is nothing to compare.
    #[error("the demo has {duration} s, so no moment comes {every} s after its start")]
    Short {
        /// Seconds.
        duration: f64,
        /// Seconds from one moment to the next.
        every: f64,
    },
}

/// Runs a demo up to each of its moments, and compares.
pub fn film(options: &FilmOptions) -> Result<Filmed, FilmError> {
    let mut session = Session::open(Options {
        project: Some(options.project.clone()),
        demo: Some(options.demo.clone()),
        graph: options.graph.as_ref().map(PathBuf::from),
        device: options.device.clone(),
        validation: options.validation,
        watchdog: std::time::Duration::from_secs(30),
        observe: Observe::Shown,
        size: options.size,
        step: Some(1.0 / options.fps),
        ..Options::default()
    })?;
    let Some(demo) = session.demo().cloned() else { return Err(FilmError::Still) };
    let moves = !demo.camera.is_empty()
        || demo.tracks.iter().next().is_some()
        || demo.inputs.is_some()
        || !demo.edits.is_empty();
    if !moves {
        return Err(FilmError::Still);
    }
    let moments = moments(&demo, options.fps, options.every);
    if moments.is_empty() {
        return Err(FilmError::Short { duration: demo.duration, every: options.every });
    }
    for (name, text) in &options.set {
        session.set_param_text(name, text)?;
    }
    let compared = moments.into_iter().map(|moment| one(&mut session, &demo, options, moment));
    let compared: Vec<Compared> = compared.collect::<Result<_, _>>()?;
    let said = session.device().log().take();
    Ok(Filmed {
        graph: session.graph_path().to_owned(),
        device: DeviceName::of(session.device()),
        moments: compared,
        messages: (session.take_messages(), session.texts().clone()),
        complaints: said.iter().map(|message| format!("[{}]: {}", message.id, message.text)).collect(),
    })
}

/// The moments of a demo, with their frames: each `every` seconds after the one before, the first as long after the start.
fn moments(demo: &Demo, fps: f64, every: f64) -> Vec<(f64, u64)> {
    let last = Moment::from(demo.duration).nearest(Fraction::of(fps)).saturating_sub(1);
    let seconds = (1..).map(|number: u32| f64::from(number) * every);
    let frames = seconds.map(|second| (second, Moment::from(second).nearest(Fraction::of(fps))));
    frames.take_while(|(_, frame)| *frame <= last).collect()
}

/// The frame of a moment, and its judgement.
fn one(
    session: &mut Session,
    demo: &Demo,
    options: &FilmOptions,
    (second, frame): (f64, u64),
) -> Result<Compared, FilmError> {
    let step = Fraction::of(1.0 / options.fps);
    let at = |frame: u64| Moment::of_frame(frame, step);
    // Nothing is seen across a cut.
    let first = (1..=frame).rev().find(|frame| demo.cuts_between(at(frame - 1), at(*frame))).unwrap_or(0);
    session.start_at(first);
    for _ in first..=frame {
        session.frame()?;
    }
    let film = displayed(session)?;
    let mut stopped = film.clone();
    for number in 1..=options.settle {
        session.again();
        session.frame()?;
        if number == options.stop {
            stopped = displayed(session)?;
        }
    }
    let settled = displayed(session)?;
    let flip = |picture: &Picture| compare(&settled, picture).map_or(1.0, |compared| compared.flip);
    let mean = |picture: &Picture| picture.pixels.iter().flatten().map(|value| f64::from(*value)).sum::<f64>();
    let brightness = match (mean(&film), mean(&settled)) {
        (film, settled) if settled > 0.0 => film / settled - 1.0,
        _ => 0.0,
    };
    Ok(Compared { second, frame, film: flip(&film), stopped: flip(&stopped), brightness })
}

fn displayed(session: &mut Session) -> Result<Picture, ReadError> {
    let picture = session.read_presented()?;
    let pixels = picture.rgba.chunks_exact(4).map(|pixel| [0, 1, 2].map(|i| f32::from(pixel[i]) / 255.0));
    Ok(Picture { width: picture.width, height: picture.height, pixels: pixels.collect(), encoding: Encoding::Display })
}
