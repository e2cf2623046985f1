//! `raxel run`: a graph or a demo in a window, live.

use raxel_gpu::DeviceOptions;
use raxel_terminal::args::{Messages, OnDevice};
use raxel_terminal::console::Console;
use raxel_terminal::failure::Result;
use raxel_window as window;

/// Opens a window: edits of graphs, shaders, worlds and demos show when they are saved, errors are printed on stderr.
#[derive(Debug, clap::Args)]
#[command(after_help = format!("In the window:\n{}", window::KEYS))]
pub(crate) struct Args {
    #[command(flatten)]
    window: window::Args,

    #[command(flatten)]
    pub messages: Messages,

    #[command(flatten)]
    pub on: OnDevice,
}

impl Args {
    /// Whether a program drives the window.
    pub(crate) fn is_driven(&self) -> bool {
        self.window.control
    }
}

pub(crate) fn run(args: &Args, device: &DeviceOptions, console: &Console) -> Result {
    window::run(&args.window, device, console)
}
