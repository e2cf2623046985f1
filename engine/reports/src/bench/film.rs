//! `raxel bench film`: the bottleneck of making frames.

use std::fmt::Write;

use raxel_gpu::DeviceOptions;
use raxel_output::{Coding, Compression, Destination, Layers, Mode, Output, Scratch, Shoot, Stages};
use raxel_terminal::args::{Messages, Size, size};
use raxel_terminal::console::{self, Console, Format};
use raxel_terminal::failure::{Failure, Result};
use raxel_terminal::session::{What, frame_failure, print_validation, validated};
use serde_json::json;

/// Measures how fast frames are made and written, and which stage bounds it: rendering, read-back, encoding or writing.
///
/// The stages overlap, on all cores. The first row is without overlap: each frame is on disk before the next begins.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example: raxel bench film worlds/valley.demo.toml --frames 240 --size 1920x1080")]
pub(crate) struct Args {
    #[command(flatten)]
    what: What,

    /// Frames of each measurement.
    #[arg(long, value_name = "N", default_value_t = 120, value_parser = clap::value_parser!(u64).range(1..))]
    frames: u64,

    /// Pixels: the project's, or 1280x720 by default.
    #[arg(long, value_name = "WxH", value_parser = size)]
    size: Option<Size>,

    #[command(flatten)]
    pub messages: Messages,
}

/// The measured cases: name, output, and how it is written.
const CASES: [(&str, &str, Compression, Mode); 5] = [
    ("png, balanced, one by one", "%05d.png", Compression::Balanced, Mode::OneByOne),
    ("png, balanced", "%05d.png", Compression::Balanced, Mode::AtOnce),
    ("png, fast", "%05d.png", Compression::Fast, Mode::AtOnce),
    ("jpg", "%05d.jpg", Compression::Fast, Mode::AtOnce),
    ("mp4", "film.mp4", Compression::Fast, Mode::AtOnce),
];

pub(crate) fn run(args: &Args, device: &DeviceOptions, console: &Console) -> Result {
    let scratch = Scratch::new()?;
    let (what, manifest) = args.what.in_project(console)?;
    let fps = what.demo().map(|demo| demo.fps).or(manifest.fps).unwrap_or(60.0);
    let mut options = what.options(device)?;
    let size = args.size.map(|size| size.0).or(manifest.size).unwrap_or(options.size);
    options.size = size;
    options.step = Some(1.0 / fps);
    let mut session = what.open(options, console)?;
    // Shaders and pipelines are made before anything is measured.
    session.frame().and_then(|_| session.wait()).map_err(|error| frame_failure(error, console))?;
    let mut first: Option<f64> = None;
    for (name, file, compression, mode) in CASES {
        let path = scratch.path().join(file);
        let output = Output::parse(&path.display().to_string(), None)?;
        let place = match Destination::prepare(&output, size, fps, 0) {
            Err(failure) if matches!(output, Output::Film(_)) => {
                console.message(&format!("{name}: left out: {}", failure.message));
                continue;
            }
            place => place?,
        };
        session.reset();
        let shoot = Shoot {
            run: 0..args.frames,
            wanted: 0..args.frames,
            layers: Layers::Picture,
            captions: None,
            coding: Coding { kind: output.kind(), compression, quality: 90 },
            samples: 1,
            settle: 0,
            mode,
        };
        let frame = |session: &mut raxel_runtime::Session| {
            session.frame().map(drop).map_err(|error| frame_failure(error, console))
        };
        let stages = shoot.run(&mut session, place, |_, _| Ok(()), frame)?;
        let bytes = written(scratch.path())?;
        let seconds = stages.wall.as_secs_f64();
        let gain = *first.get_or_insert(seconds) / seconds;
        print(name, &stages, bytes, gain, console);
    }
    let complaints = print_validation(&session, console);
    validated(complaints)
}

/// Bytes of the folder's files; it is empty afterwards.
fn written(folder: &std::path::Path) -> Result<u64> {
    let failed = |error: std::io::Error| Failure::usage(format!("`{}`: {error}", folder.display()));
    let mut bytes = 0;
    for entry in std::fs::read_dir(folder).map_err(failed)? {
        let entry = entry.map_err(failed)?;
        bytes += entry.metadata().map_err(failed)?.len();
        std::fs::remove_file(entry.path()).map_err(failed)?;
    }
    Ok(bytes)
}

fn print(name: &str, stages: &Stages, bytes: u64, gain: f64, console: &Console) {
    let seconds = stages.wall.as_secs_f64();
    let frames = stages.frames as f64;
    if console.format() == Format::Json {
        let shares: serde_json::Map<_, _> =
            stages.shares().into_iter().map(|(stage, share)| (stage.replace(' ', "_"), json!(share))).collect();
        return console::json(&json!({
            "reason": "film",
            "case": name,
            "frames": stages.frames,
            "seconds": seconds,
            "bytes": bytes,
            "encoders": stages.workers,
            "busy": shares,
            "bound": stages.bound(),
            "gain": gain,
        }));
    }
    let mut text = format!(
        "{name:26} {:8.2} ms a frame, {:6.2} s, {:8.1} KiB a frame, {gain:5.1}×; busy:",
        seconds / frames * 1e3,
        seconds,
        bytes as f64 / frames / 1024.0,
    );
    for (stage, share) in stages.shares() {
        let _ = write!(text, " {stage} {:.0} %,", share * 100.0);
    }
    let _ = writeln!(text, " bound by {}", stages.bound());
    console::data(&text);
}
