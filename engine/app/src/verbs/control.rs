//! `raxel control`: a session without a window that a program drives.

use raxel_control::{Control, Drive};
use raxel_diagnostics::Severity;
use raxel_gpu::DeviceOptions;
use raxel_runtime::Observe;
use raxel_terminal::args::{OnDevice, Size, size};
use raxel_terminal::console::Console;
use raxel_terminal::failure::Result;
use raxel_terminal::program::Program;
use raxel_terminal::session::{What, print_validation, validated};

/// Runs a session that a program controls by lines of JSON on stdin.
///
/// A request sets params, moves the camera, runs frames, reads pixels and buffers, or waits for edits. Each gets one answer on stdout.
/// docs/control.md has the protocol; the Python package in `python/` uses it.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  \
    printf '{\"do\":\"step\"}\\n{\"do\":\"screenshot\",\"path\":\"a.png\"}\\n' | raxel control graphs/primary.toml")]
pub(crate) struct Args {
    #[command(flatten)]
    what: What,

    /// Pixels: the project's, or 1280x720 by default.
    #[arg(long, value_name = "WxH", value_parser = size)]
    size: Option<Size>,

    /// Frames a second, time that passes with each frame: the project's, or 60 by default.
    #[arg(long, value_name = "RATE", value_parser = super::render::rate)]
    fps: Option<f64>,

    #[command(flatten)]
    pub on: OnDevice,
}

pub(crate) fn run(args: &Args, device: &DeviceOptions, console: &Console) -> Result {
    let (what, manifest) = args.what.in_project(console)?;
    let mut options = what.options(device)?;
    options.size = args.size.map(|size| size.0).or(manifest.size).unwrap_or(options.size);
    options.step = Some(1.0 / args.fps.or(manifest.fps).unwrap_or(60.0));
    options.watch = true;
    options.unused = Severity::Warning;
    options.observe = Observe::Everything;
    let mut session = what.open(options, console)?;
    Control::listen(Drive::Requests, Program::AtOnce, || ()).serve(&mut session);
    validated(print_validation(&session, console))
}
