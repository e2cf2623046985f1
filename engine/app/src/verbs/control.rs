//! `raxel control`: a session without a window that a program drives.

use raxel_gpu::DeviceOptions;

use crate::args::{Size, size};
use crate::console::Console;
use crate::control::{Control, Drive};
use crate::failure::Result;
use crate::session::{What, print_validation, validated};

/// Opens a session without a window and does what lines of JSON on stdin ask: set params, move the camera, run frames, read pixels and
/// buffers, wait for edits. Each line has one answer on stdout; docs/control.md tells all. The Python package in `python/` speaks it.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  \
    printf '{\"do\":\"step\"}\\n{\"do\":\"screenshot\",\"path\":\"a.png\"}\\n' | raxel control graphs/primary.toml")]
pub(crate) struct Args {
    #[command(flatten)]
    what: What,

    /// Pixels.
    #[arg(long, value_name = "WxH", value_parser = size, default_value = "1280x720")]
    size: Size,

    /// Frames a second: time that passes with each frame.
    #[arg(long, value_name = "RATE", default_value_t = 60.0, value_parser = super::render::rate)]
    fps: f64,
}

pub(crate) fn run(args: &Args, device: &DeviceOptions, console: &Console) -> Result {
    let mut options = args.what.options(device)?;
    options.size = args.size.0;
    options.step = Some(1.0 / args.fps);
    options.watch = true;
    let mut session = args.what.open(options, console)?;
    Control::listen(Drive::Requests, || ()).serve(&mut session);
    validated(print_validation(&session, console))
}
