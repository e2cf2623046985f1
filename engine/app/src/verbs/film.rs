//! `raxel film`: numbered frames, made by as many machines as you like, as one film.

use std::path::{Path, PathBuf};

use raxel_output::{Destination, Output, shown};
use raxel_terminal::args::Messages;
use raxel_terminal::console::{self, Console, Format};
use raxel_terminal::failure::{Failure, Result};
use rayon::iter::{IntoParallelIterator, ParallelIterator};
use serde_json::json;

/// Makes a film of numbered frames through ffmpeg.
///
/// It has the same bytes as a film that `raxel render` makes of the demo at once.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  raxel render worlds/valley.demo.toml --shard 1/2 -o frames/%04d.png\n  \
                        raxel render worlds/valley.demo.toml --shard 2/2 -o frames/%04d.png\n  \
                        raxel film frames/%04d.png --fps 30 -o valley.mp4")]
pub(crate) struct Args {
    /// PNG files numbered from 0, such as frames/%04d.png, or their folder.
    #[arg(value_name = "FRAMES")]
    frames: String,

    /// FILE.mp4; also mkv, mov, webm, gif.
    #[arg(short, long, value_name = "FILE")]
    output: String,

    /// Frames a second.
    #[arg(long, value_name = "RATE", default_value_t = 30.0, value_parser = super::render::rate)]
    fps: f64,

    #[command(flatten)]
    pub messages: Messages,
}

/// Frames that are decoded at once.
const AT_ONCE: u64 = 16;

#[expect(clippy::cast_possible_truncation, reason = "`AT_ONCE` is small")]
pub(crate) fn run(args: &Args, console: &Console) -> Result {
    let Output::Frames(_, pattern) = Output::parse(&args.frames, None)? else {
        return Err(Failure::usage(format!("`{}` names no numbered frames", args.frames)).help("frames/%04d.png"));
    };
    let output = Output::parse(&args.output, None)?;
    if !matches!(output, Output::Film(_)) {
        return Err(Failure::usage(format!("`{}` is not a film", args.output)).help("-o film.mp4"));
    }
    let count = (0..u64::MAX).take_while(|frame| pattern.file(*frame).is_file()).count() as u64;
    if count == 0 {
        let missing = Failure::usage(format!("there is no `{}`", pattern.file(0).display()));
        return Err(missing.help("frames count from 0; name them with their digits, e.g. frames/%04d.png"));
    }
    let first = decode(&pattern.file(0))?;
    let size = [first.width(), first.height()];
    let mut place = Destination::prepare(&output, size, args.fps, 0)?;
    for start in (0..count).step_by(AT_ONCE as usize) {
        let end = count.min(start + AT_ONCE);
        let frames: Vec<_> = (start..end).into_par_iter().map(|frame| decode(&pattern.file(frame))).collect();
        for (frame, picture) in (start..end).zip(frames) {
            let picture = picture?;
            if [picture.width(), picture.height()] != size {
                let file = pattern.file(frame);
                let [width, height] = size;
                return Err(Failure::usage(format!("`{}` is not {width}×{height} pixels", file.display())));
            }
            place.write(frame, picture.as_raw())?;
        }
    }
    place.finish()?;
    let (path, [width, height]) = (shown(&PathBuf::from(&args.output)), size);
    if console.format() == Format::Json {
        console::json(&json!({ "reason": "film", "file": path, "size": size, "frames": count }));
    } else {
        console.message(&format!("wrote {path} ({width}×{height}, {count} frames)"));
    }
    Ok(())
}

fn decode(path: &Path) -> Result<image::RgbaImage> {
    let failed =
        |error: &dyn std::fmt::Display| Failure::usage(format!("`{}` cannot be read: {error}", path.display()));
    let bytes = std::fs::read(path).map_err(|error| failed(&error))?;
    Ok(image::load_from_memory(&bytes).map_err(|error| failed(&error))?.into_rgba8())
}
