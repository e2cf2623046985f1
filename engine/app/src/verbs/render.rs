//! `raxel render`: pictures, frames and films without a window. The same command gives the same bytes.

use std::fmt::Write;
use std::io::IsTerminal;
use std::time::Instant;

use indicatif::{ProgressBar, ProgressStyle};
use raxel_gpu::DeviceOptions;
use raxel_runtime::execute::Picture;
use raxel_runtime::session::Session;
use serde_json::json;

use crate::args::{Messages, Size, size};
use crate::console::{self, Console, Format};
use crate::failure::{Failure, Result};
use crate::output::{self, Film, Folders, Kind, Output, Pending, shown};
use crate::session::{What, frame_failure, print_validation, validated};

/// Renders to PNG (as displayed), EXR (the target's own texels), numbered frames, or a film. Time is frame × step: the same command
/// gives the same bytes.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  raxel render -o p.png\n  \
                        raxel render graphs/inspect.toml --world worlds/menger.toml --target depth -o depth.exr\n  \
                        raxel render worlds/valley.demo.toml -o valley.mp4\n  \
                        raxel render graphs/primary.toml --frames 120 --shard 1/4 -o frames/%04d.png")]
pub(crate) struct Args {
    #[command(flatten)]
    what: What,

    /// What to write: FILE.png, FILE.exr, frames/%04d.png, a folder, FILE.mp4 (also mkv, mov, webm, gif; needs ffmpeg). EXR has no
    /// signed integers: those of 32 bits are written as unsigned ones, in two's complement.
    #[arg(short, long, value_name = "FILE")]
    output: String,

    /// Pixels.
    #[arg(long, value_name = "WxH", value_parser = size, default_value = "1280x720")]
    size: Size,

    /// How many frames to run. By default 1 for a picture, the whole demo for frames and films. A single picture is of the last one.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    frames: Option<u64>,

    /// Frames a second: of the film, and of the time that passes. The demo's, or 60 by default.
    #[arg(long, value_name = "RATE", value_parser = rate)]
    fps: Option<f64>,

    /// Write the I-th of N equal parts of the frames only (I from 1); the parts together are all frames.
    #[arg(long, value_name = "I/N", value_parser = shard)]
    shard: Option<Shard>,

    /// Print each pass's GPU time (median over the frames) on stdout.
    #[arg(long)]
    time: bool,

    #[command(flatten)]
    pub messages: Messages,
}

fn rate(text: &str) -> std::result::Result<f64, String> {
    text.parse()
        .ok()
        .filter(|rate| (0.001..=1000.0).contains(rate))
        .ok_or_else(|| "a number from 0.001 to 1000".to_owned())
}

/// One part of the frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Shard {
    /// From 1.
    part: u64,
    of: u64,
}

fn shard(text: &str) -> std::result::Result<Shard, String> {
    text.split_once('/')
        .and_then(|(part, of)| Some(Shard { part: part.parse().ok()?, of: of.parse().ok()? }))
        .filter(|shard| (1..=shard.of).contains(&shard.part))
        .ok_or_else(|| "write PART/PARTS, e.g. 1/4".to_owned())
}

impl Shard {
    /// The frames of this part, of `frames` in all.
    fn range(self, frames: u64) -> std::ops::Range<u64> {
        let at = |part: u64| (u128::from(frames) * u128::from(part) / u128::from(self.of)) as u64;
        at(self.part - 1)..at(self.part)
    }
}

pub(crate) fn run(args: &Args, device: &DeviceOptions, console: &Console) -> Result {
    let output = Output::parse(&args.output)?;
    if args.shard.is_some() && !matches!(output, Output::Frames(..)) {
        return Err(Failure::usage("`--shard` divides numbered frames").help("-o frames/%04d.png"));
    }
    let demo = args.what.demo_length();
    let fps = args.fps.or(demo.map(|(_, fps)| fps)).unwrap_or(60.0);
    let frames = args.frames.unwrap_or(match (&output, demo) {
        (Output::Frames(..) | Output::Film(_), Some((seconds, _))) => (seconds * fps).round().max(1.0) as u64,
        _ => 1,
    });
    let range = args.shard.map_or(0..frames, |shard| shard.range(frames));

    // Whether the result can be written is found out before anything else.
    let mut sink = Sink::prepare(&output, args.size.0, fps, range.start)?;

    let mut options = args.what.options(device)?;
    options.size = args.size.0;
    options.step = Some(1.0 / fps);
    let mut session = args.what.open(options, console)?;
    let target = Raw::of(&session, &output)?;

    let start = Instant::now();
    let bar = progress(range.end, console);
    let mut times = Times::default();
    for frame in 0..range.end {
        session.frame().map_err(|error| frame_failure(error, console))?;
        if args.time {
            times.add(&mut session, console)?;
        }
        let wanted = if sink.is_single() { frame + 1 == range.end } else { range.contains(&frame) };
        if wanted {
            sink.frame(&mut session, target.as_ref(), frame)?;
        }
        bar.inc(1);
    }
    bar.finish_and_clear();
    let complaints = print_validation(&session, console);
    let size = sink.finish()?.unwrap_or(args.size.0);

    let seconds = start.elapsed().as_secs_f64();
    report(&output, size, &session, &range, seconds, &times, console);
    validated(complaints)
}

/// The raw texels that an EXR is made of.
struct Raw {
    resource: String,
    age: u32,
    mip: u32,
    layer: u32,
}

impl Raw {
    fn of(session: &Session, output: &Output) -> Result<Option<Self>> {
        if !output.wants_texels() {
            return Ok(None);
        }
        let shown = session.debug_target();
        if shown.after.is_some() {
            return Err(Failure::usage(
                "`--after` shows a target as a picture; an EXR has the texels at the end of the frame",
            )
            .help("write a .png, or leave `--after` out"));
        }
        let graph = session.graph();
        let resource =
            if shown.resource.is_empty() { graph.resource(graph.present).name.clone() } else { shown.resource.clone() };
        Ok(Some(Self { resource, age: shown.age, mip: shown.mip, layer: shown.layer }))
    }
}

/// Where frames go while they are made.
struct Sink<'o> {
    to: To<'o>,
    /// The extent of the last picture in pixels.
    size: Option<[u32; 2]>,
}

enum To<'o> {
    Single(Kind, Option<Pending>),
    Frames { kind: Kind, pattern: &'o output::Pattern, _folders: Folders },
    Film(Film),
}

impl<'o> Sink<'o> {
    fn prepare(output: &'o Output, size: [u32; 2], fps: f64, first: u64) -> Result<Self> {
        let to = match output {
            Output::Single(kind, path) => To::Single(*kind, Some(Pending::new(path)?)),
            Output::Frames(kind, pattern) => To::Frames { kind: *kind, pattern, _folders: pattern.prepare(first)? },
            Output::Film(path) => To::Film(Film::start(path, size, fps)?),
        };
        Ok(Self { to, size: None })
    }

    /// Whether one picture is made, of the last frame.
    fn is_single(&self) -> bool {
        matches!(self.to, To::Single(..))
    }

    fn frame(&mut self, session: &mut Session, raw: Option<&Raw>, frame: u64) -> Result {
        let size = match &mut self.to {
            To::Single(kind, pending) => match pending.take() {
                Some(pending) => write(*kind, pending, session, raw)?,
                None => return Ok(()),
            },
            To::Frames { kind, pattern, .. } => write(*kind, Pending::new(&pattern.file(frame))?, session, raw)?,
            To::Film(film) => {
                let picture = picture(session)?;
                film.frame(&picture)?;
                [picture.width, picture.height]
            }
        };
        self.size = Some(size);
        Ok(())
    }

    /// The extent of what was written; `None` if no frame was.
    fn finish(self) -> Result<Option<[u32; 2]>> {
        if let To::Film(film) = self.to {
            film.finish()?;
        }
        Ok(self.size)
    }
}

fn picture(session: &mut Session) -> Result<Picture> {
    Ok(session.read_presented()?)
}

/// Writes a frame, and gives its extent.
fn write(kind: Kind, pending: Pending, session: &mut Session, raw: Option<&Raw>) -> Result<[u32; 2]> {
    if let (Kind::Exr, Some(raw)) = (kind, raw) {
        let texels = session.read_texels(&raw.resource, raw.age, raw.mip, raw.layer)?;
        output::write_texels(pending, &texels, &raw.resource)?;
        return Ok([texels.width, texels.height]);
    }
    let picture = picture(session)?;
    output::write_picture(pending, &picture)?;
    Ok([picture.width, picture.height])
}

/// GPU times of the passes over the frames.
#[derive(Default)]
struct Times {
    passes: Vec<(String, Vec<f64>)>,
}

impl Times {
    /// Takes the times of the frame just made; it is waited for.
    fn add(&mut self, session: &mut Session, console: &Console) -> Result {
        session.wait().map_err(|error| frame_failure(error, console))?;
        // Rounds of a loop are passes of the plan.
        let Some(plan) = session.plan().cloned() else { return Ok(()) };
        for time in session.timings() {
            let name = &plan.graph.pass(time.pass).name;
            let Some(nanoseconds) = time.nanoseconds else { continue };
            match self.passes.iter_mut().find(|(known, _)| known == name) {
                Some((_, samples)) => samples.push(nanoseconds),
                None => self.passes.push((name.clone(), vec![nanoseconds])),
            }
        }
        Ok(())
    }

    /// Each pass with the median of its milliseconds and the number of frames it ran in.
    fn medians(&self) -> Vec<(&str, f64, usize)> {
        self.passes
            .iter()
            .map(|(name, samples)| {
                let mut sorted = samples.clone();
                sorted.sort_by(f64::total_cmp);
                (name.as_str(), sorted[sorted.len() / 2] / 1e6, sorted.len())
            })
            .collect()
    }
}

fn progress(frames: u64, console: &Console) -> ProgressBar {
    if frames < 2 || !console.watched() || !std::io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let style = ProgressStyle::with_template("{bar:30} {pos}/{len} frames, {eta} left");
    ProgressBar::new(frames).with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
}

fn report(
    output: &Output,
    [width, height]: [u32; 2],
    session: &Session,
    range: &std::ops::Range<u64>,
    seconds: f64,
    times: &Times,
    console: &Console,
) {
    let written = match output {
        Output::Single(_, path) | Output::Film(path) => shown(path),
        Output::Frames(..) => output.describe(),
    };
    let medians = times.medians();
    if console.format() == Format::Json {
        let passes: Vec<_> = medians
            .iter()
            .map(|(pass, milliseconds, frames)| json!({ "pass": pass, "milliseconds": milliseconds, "frames": frames }))
            .collect();
        return console::json(&json!({
            "reason": "rendered",
            "file": written,
            "graph": session.graph_path(),
            "size": [width, height],
            "frames": [range.start, range.end],
            "seconds": seconds,
            "device": session.device().capabilities().name,
            "passes": passes,
        }));
    }
    let mut text = String::new();
    for (pass, milliseconds, frames) in &medians {
        let _ = writeln!(
            text,
            "{milliseconds:10.3} ms  {pass}{}",
            if *frames > 1 { format!("  (median of {frames})") } else { String::new() }
        );
    }
    console::data(&text);
    let frames = range.end - range.start;
    let what = if frames == 1 { String::new() } else { format!(", {frames} frames") };
    console.message(&format!("wrote {written} ({width}×{height}{what}, {seconds:.2} s)"));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shards_are_all_frames_once() {
        for (frames, of) in [(10, 3), (1, 4), (120, 7), (5, 1)] {
            let mut next = 0;
            for part in 1..=of {
                let range = Shard { part, of }.range(frames);
                assert_eq!(range.start, next);
                next = range.end;
            }
            assert_eq!(next, frames);
        }
        assert!(shard("0/4").is_err() && shard("5/4").is_err() && shard("4").is_err() && shard("1/0").is_err());
    }
}
