//! `raxel render`: pictures, frames and films without a window. The same command gives the same bytes.

use std::fmt::Write;
use std::io::IsTerminal;
use std::ops::Range;
use std::path::{Path, PathBuf};

use indicatif::{ProgressBar, ProgressStyle};
use raxel_execute::moment::{Fraction, Moment};
use raxel_gpu::DeviceOptions;
use raxel_output::{
    Coding, Compression, Destination, FrameList, Layer, Layers, MOST_LAYERS, Mode, Output, PictureFormat, Shoot,
    Stages, shown,
};
use raxel_runtime::session::Session;
use raxel_runtime::timeline::Demo;
use raxel_terminal::args::{Messages, OnDevice, Size, size};
use raxel_terminal::console::{self, Console, Format};
use raxel_terminal::failure::{Failure, Result};
use raxel_terminal::offline::OfflineProject;
use raxel_terminal::prints::print_prints;
use raxel_terminal::session::{What, frame_failure, print_messages, print_validation, validated};
use serde_json::json;

/// Renders to PNG or JPEG (as displayed), EXR or HDR (the target's own texels), numbered frames, a film, or stdout.
///
/// Time is frame × step: the same command gives the same bytes.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  raxel render -o p.png\n  \
                        raxel render graphs/inspect.toml --world worlds/menger.toml --layers depth,normal -o layers.exr\n  \
                        raxel render worlds/valley.demo.toml -o valley.mp4\n  \
                        raxel render worlds/valley.demo.toml --at 2.5s --samples 16 -o smooth.png\n  \
                        raxel render worlds/valley.demo.toml --as raw -o - | ffmpeg -f rawvideo -pix_fmt rgba -s 1280x720 -r 30 -i - a.mkv\n  \
                        raxel render graphs/primary.toml --frames 120 --shard 1/4 -o frames/%04d.png")]
pub(crate) struct Args {
    #[command(flatten)]
    what: What,

    /// The files to write: FILE.png, .jpg, .exr, .hdr, frames/%04d.png, a folder, FILE.mp4 (also mkv, mov, webm, gif; needs ffmpeg), or `-` for
    /// stdout, frame after frame. EXR has no signed integers: those of 32 bits are written as unsigned ones, in two's complement.
    #[arg(short, long, value_name = "FILE")]
    output: String,

    /// The form of a picture where its name does not say it: on stdout, in a folder.
    #[arg(long = "as", value_enum, value_name = "KIND")]
    kind: Option<PictureFormat>,

    /// How much time goes into making a PNG small.
    #[arg(long, value_enum, default_value_t, value_name = "LEVEL")]
    compression: Compression,

    /// Quality of a JPEG: 1 is the smallest file, 100 the best picture.
    #[arg(long, value_name = "N", default_value_t = 90, value_parser = clap::value_parser!(u8).range(1..=100))]
    quality: u8,

    /// Write these targets as the layers of an EXR, rather than the one that is shown.
    #[arg(long, value_name = "TARGET,…", value_delimiter = ',', conflicts_with_all = ["target", "after"])]
    layers: Vec<String>,

    /// Pixels: the demo's or the project's, or 1280x720 by default.
    #[arg(long, value_name = "WxH", value_parser = size)]
    pub(super) size: Option<Size>,

    /// Average N pictures for each frame, with rays at different places in the pixels: smooth edges.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=4096))]
    samples: u32,

    /// Run N frames of the same moment before each picture, for graphs that average over time.
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = clap::value_parser!(u32).range(..=65_535))]
    pub(super) settle: u32,

    /// How many frames to run. By default 1 for a picture, the whole demo for frames and films. A single picture is of the last one.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    pub(super) frames: Option<u64>,

    /// Write the frame at this time only, e.g. 2.5s: the same bytes as in the whole film.
    #[arg(long, value_name = "SECONDS", value_parser = seconds, conflicts_with_all = ["frames", "shard"])]
    pub(super) at: Option<f64>,

    /// Frames a second: of the film, and of the time that passes. The demo's or the project's, or 60 by default.
    #[arg(long, value_name = "RATE", value_parser = rate)]
    pub(super) fps: Option<f64>,

    /// Write the I-th of N equal parts of the frames only (I from 1); the parts together are all frames. Frames before the part are run
    /// only if the graph keeps something from frame to frame.
    #[arg(long, value_name = "I/N", value_parser = shard)]
    shard: Option<Shard>,

    /// List finished frames in this file. Run again, the same command leaves out the frames that it lists and whose files are as they were
    /// written: after it was killed, it goes on where it was.
    #[arg(long, value_name = "LIST")]
    resume: Option<PathBuf>,

    /// Print each pass's GPU time on stdout: the median over the frames in which it ran. With `--frames N`, all N frames are run for it.
    #[arg(long)]
    time: bool,

    #[command(flatten)]
    pub messages: Messages,

    #[command(flatten)]
    pub on: OnDevice,
}

fn seconds(text: &str) -> std::result::Result<f64, String> {
    let number = text.strip_suffix('s').unwrap_or(text).trim();
    (number.parse().ok().filter(|seconds| (0.0..=86_400.0).contains(seconds)))
        .ok_or_else(|| "seconds from 0 to 86400, e.g. 2.5s".to_owned())
}

/// `60`, `29.97`, `30000/1001`.
pub(super) fn rate(text: &str) -> std::result::Result<f64, String> {
    let (above, below) = text.split_once('/').unwrap_or((text, "1"));
    let number = |text: &str| text.trim().parse::<f64>().ok();
    (number(above).zip(number(below)).map(|(above, below)| above / below))
        .filter(|rate| (0.001..=1000.0).contains(rate))
        .ok_or_else(|| "a number from 0.001 to 1000, e.g. 60, 29.97 or 30000/1001".to_owned())
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
    #[expect(
        clippy::cast_possible_truncation,
        reason = "a part is at most the whole, so that a bound is at most `frames`"
    )]
    fn range(self, frames: u64) -> std::ops::Range<u64> {
        let at = |part: u64| (u128::from(frames) * u128::from(part) / u128::from(self.of)) as u64;
        at(self.part - 1)..at(self.part)
    }
}

pub(crate) fn run(args: &Args, device: &DeviceOptions, console: &Console) -> Result {
    let output = Output::parse(&args.output, args.kind)?;
    args.check(&output, console)?;
    let (what, manifest) = args.what.in_project(console)?;
    let demo = what.demo();
    let fps = args.fps.or(demo.as_ref().map(|demo| demo.fps)).or(manifest.fps).unwrap_or(60.0);
    if let (Some(at), Some(demo)) = (args.at, demo.as_deref())
        && at > demo.duration
        && !demo.looped
    {
        let Demo { name, duration, .. } = demo;
        return Err(Failure::usage(format!(
            "`--at {at}s` is after the end of the demo `{name}`, which has {duration} s"
        )));
    }
    let mut wanted = args.wanted(&output, demo.as_deref(), fps);
    let size = args.size.map(|size| size.0).or(demo.as_ref().map(|demo| demo.size)).or(manifest.size);
    let size = size.unwrap_or([1280, 720]);

    // First of all, find out whether the result can be written.
    let mut place = Destination::prepare(&output, size, fps, wanted.start)?;
    if let (Some(list), Output::Frames(_, pattern)) = (&args.resume, &output) {
        let list = FrameList::open(list, &command())?;
        let finished = list.finished(wanted.clone(), pattern);
        if finished > 0 {
            let all = wanted.end - wanted.start;
            console.message(&format!("{finished} of {all} frames are there already: {}", output.describe()));
            wanted.start += finished;
        }
        if wanted.is_empty() {
            return Ok(());
        }
        place = place.listing(list);
    }

    let mut options = what.options(device)?;
    options.size = size;
    options.step = Some(1.0 / fps);
    options.pinned.clone_from(&args.layers);
    let mut session = what.open(options.clone(), console)?;
    let step = Fraction::of(1.0 / fps);
    let make = |session: &mut Session, output: &Output, place: Destination| {
        let shoot = Shoot {
            run: args.start(session, &wanted, step)..wanted.end,
            captions: demo.clone().map(|demo| (demo, step)),
            layers: args.layers(session, output.kind()),
            wanted: wanted.clone(),
            coding: Coding { kind: output.kind(), compression: args.compression, quality: args.quality },
            samples: args.samples,
            settle: args.settle,
            mode: Mode::AtOnce,
        };
        args.shoot(session, &shoot, output, place, console)
    };
    match (&output, make(&mut session, &output, place)) {
        (Output::Film(film), Err(failure)) if failure.ffmpeg => {
            let frames = Output::frames_of(film);
            console.message(&format!("the film cannot be written; its frames go to {}", frames.describe()));
            session = what.open(options, console)?;
            // Frames of an earlier film, which may have had more, would go into the film that is made of the folder.
            let place = frames.clear().and_then(|()| Destination::prepare(&frames, size, fps, wanted.start));
            Err(match place.map_err(Failure::from).and_then(|place| make(&mut session, &frames, place)) {
                Ok(()) => failure.help(format!(
                    "`raxel film {} --fps {fps} -o {}` makes the film of its frames",
                    console::word(Path::new(&frames.describe())),
                    console::word(film)
                )),
                Err(lost) => failure.help(format!("its frames cannot be kept: {}", lost.message.unwrap_or_default())),
            })
        }
        (_, made) => made,
    }
}

impl Args {
    /// The first frame to run for the wanted frames. Moves the session there. The camera of the frame before is known to
    /// every frame, so one more is run. A graph that looks back is run from the last cut of its demo. Frames whose times are asked for are all run.
    fn start(&self, session: &mut Session, wanted: &Range<u64>, step: Fraction) -> u64 {
        let at = |frame: u64| Moment::of_frame(frame, step);
        let graph = session.graph_at(at(wanted.start));
        let first = if self.time && self.frames.is_some() && self.shard.is_none() {
            0
        } else if OfflineProject::uses_history(graph, session.size()) {
            let cut = |frame: &u64| session.demo().is_some_and(|demo| demo.cuts_between(at(frame - 1), at(*frame)));
            (1..=wanted.start).rev().find(cut).unwrap_or(0)
        } else {
            wanted.start.saturating_sub(1)
        };
        if first > 0 {
            session.start_at(first);
        }
        first
    }

    /// Renders to `output` with the default of every other option.
    pub(super) fn new(what: What, output: String, messages: Messages, on: OnDevice) -> Self {
        Self {
            what,
            output,
            kind: None,
            compression: Compression::default(),
            quality: 90,
            layers: Vec::new(),
            size: None,
            samples: 1,
            settle: 0,
            frames: None,
            at: None,
            fps: None,
            shard: None,
            resume: None,
            time: false,
            messages,
            on,
        }
    }

    /// Makes the frames, and says what was written.
    fn shoot(
        &self,
        session: &mut Session,
        shoot: &Shoot,
        output: &Output,
        place: Destination,
        console: &Console,
    ) -> Result {
        let bar = progress(shoot.run.end - shoot.run.start, console);
        let mut times = Times::default();
        let each = |session: &mut Session, _| {
            if self.time {
                times.add(session, console)?;
            }
            bar.suspend(|| print_prints(session, console));
            bar.inc(1);
            Ok(())
        };
        let frame = |session: &mut Session| session.frame().map(drop).map_err(|error| frame_failure(error, console));
        let stages = shoot.run(session, place, each, frame)?;
        bar.finish_and_clear();
        let asserted = print_messages(session, console);
        let complaints = print_validation(session, console);
        report(output, session, shoot, &stages, &times, console);
        validated(complaints).and(asserted)
    }

    /// Refuses options that do not go together.
    fn check(&self, output: &Output, console: &Console) -> Result {
        if self.shard.is_some() && !matches!(output, Output::Frames(..)) {
            return Err(Failure::usage("`--shard` divides numbered frames").help("-o frames/%04d.png"));
        }
        if self.resume.is_some() && !matches!(output, Output::Frames(..)) {
            return Err(Failure::usage("`--resume` lists numbered frames").help("-o frames/%04d.png"));
        }
        if matches!(output, Output::Stream(_)) && (self.time || console.format() == Format::Json) {
            let what = if self.time { "--time" } else { "--format json" };
            return Err(Failure::usage(format!("`-o -` and `{what}` both write to stdout")));
        }
        if !self.layers.is_empty() && output.kind() != PictureFormat::Exr {
            return Err(Failure::usage("`--layers` makes an EXR").help("-o layers.exr"));
        }
        let twice = self.layers.iter().enumerate().find(|(index, layer)| self.layers[..*index].contains(layer));
        if let Some((_, layer)) = twice {
            return Err(Failure::usage(format!("`--layers` names `{layer}` twice")));
        }
        if self.layers.len() > MOST_LAYERS {
            return Err(Failure::usage(format!("{} layers; {MOST_LAYERS} is the most", self.layers.len())));
        }
        if output.kind().wants_texels() && self.what.debug_target()?.after.is_some() {
            return Err(Failure::usage(
                "`after` shows a target as a picture; an EXR has the texels at the end of the frame",
            )
            .help("write a .png, or leave `after` out"));
        }
        Ok(())
    }

    /// The frames to write.
    fn wanted(&self, output: &Output, demo: Option<&Demo>, fps: f64) -> Range<u64> {
        let frame_at = |seconds: f64| Moment::from(seconds).nearest(Fraction::of(fps));
        if let Some(at) = self.at {
            let frame = frame_at(at);
            return frame..frame + 1;
        }
        let frames = self.frames.unwrap_or(match (output, demo) {
            (Output::Single(..), _) | (_, None) => 1,
            (_, Some(demo)) => frame_at(demo.duration).max(1),
        });
        match (output, self.shard) {
            (Output::Single(..), _) => frames - 1..frames,
            (_, Some(shard)) => shard.range(frames),
            (_, None) => 0..frames,
        }
    }

    /// The data that is read back of each frame.
    fn layers(&self, session: &mut Session, kind: PictureFormat) -> Layers {
        if !kind.wants_texels() {
            return Layers::Picture;
        }
        if !self.layers.is_empty() {
            let layer = |name: &String| Layer { resource: name.clone(), age: 0, mip: 0, layer: 0 };
            return Layers::Targets(self.layers.iter().map(layer).collect());
        }
        let shown = session.debug_target().clone();
        let graph = session.graph();
        let resource =
            if shown.resource.is_empty() { graph.resource(graph.present).name.clone() } else { shown.resource };
        if session.demo().is_some() {
            // The demo may show something else meanwhile.
            let _ = session.pin(&resource);
        }
        Layers::Targets(vec![Layer { resource, age: shown.age, mip: shown.mip, layer: shown.layer }])
    }
}

/// The command that makes the frames of a list: this program and its arguments.
fn command() -> String {
    let arguments = std::env::args().skip(1);
    arguments.fold(format!("raxel {}", env!("CARGO_PKG_VERSION")), |text, argument| text + " " + &argument)
}

/// GPU times of the passes over the frames.
#[derive(Default)]
struct Times {
    passes: Vec<(String, Vec<f64>)>,
    /// Frames that were run.
    frames: usize,
}

impl Times {
    /// Takes the times of the frame just made; it is waited for.
    fn add(&mut self, session: &mut Session, console: &Console) -> Result {
        session.wait().map_err(|error| frame_failure(error, console))?;
        self.frames += 1;
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

fn report(output: &Output, session: &Session, shoot: &Shoot, stages: &Stages, times: &Times, console: &Console) {
    let written = match output {
        Output::Single(_, path) | Output::Film(path) => shown(path),
        Output::Frames(..) | Output::Stream(_) => output.describe(),
    };
    let [width, height] = stages.size.unwrap_or_else(|| session.size());
    let seconds = stages.wall.as_secs_f64();
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
            "frames": [shoot.wanted.start, shoot.wanted.end],
            "run": [shoot.run.start, shoot.run.end],
            "seconds": seconds,
            "device": session.device().capabilities().name,
            "passes": passes,
        }));
    }
    let mut text = String::new();
    for (pass, milliseconds, frames) in &medians {
        let of = match times.frames {
            1 => String::new(),
            all if all == *frames => format!("  (median of {all} frames)"),
            all => format!("  (median of the {frames} of {all} frames that ran it)"),
        };
        let _ = writeln!(text, "{milliseconds:10.3} ms  {pass}{of}");
    }
    if !text.is_empty() {
        console::data(&text);
    }
    let what = if stages.frames == 1 { String::new() } else { format!(", {} frames", stages.frames) };
    console.message(&format!("wrote {written} ({width}×{height}{what}, {seconds:.2} s)"));
    let shares = stages.shares().map(|(stage, share)| format!("{stage} {:.0} %", share * 100.0)).join(", ");
    console.detail(&format!("busy: {shares}; bound by {}", stages.bound()));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rates_are_numbers_or_fractions() {
        let parts = |text: &str| rate(text).map(|rate| Fraction::of(rate).parts());
        assert_eq!(parts("30000/1001"), Ok((30000, 1001)));
        assert_eq!((parts("29.97"), parts("0.001")), (Ok((2997, 100)), Ok((1, 1000))));
        for text in ["", "0", "-1", "1001", "nan", "inf", "1/0", "0/0", "60/", "/2", "1/2/3", "60fps"] {
            assert!(rate(text).is_err(), "{text}");
        }
    }

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
