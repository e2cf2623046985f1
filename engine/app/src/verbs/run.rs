//! `raxel run`: a graph or a demo in a window, live.

use raxel_gpu::DeviceOptions;

use crate::args::{Messages, OnDevice};
use crate::console::Console;
use crate::failure::Result;
use crate::viewer;

/// Opens a window: edits of graphs, shaders, worlds and demos show when they are saved, errors are printed on stderr.
#[derive(Debug, clap::Args)]
#[command(after_help = format!("In the window:\n{}", viewer::KEYS))]
pub(crate) struct Args {
    #[command(flatten)]
    window: viewer::Args,

    #[command(flatten)]
    pub messages: Messages,

    #[command(flatten)]
    pub on: OnDevice,
}

pub(crate) fn run(args: &Args, device: &DeviceOptions, console: &Console) -> Result {
    viewer::run(&args.window, device, console)
}
