//! The options of a window.

use raxel_terminal::args::{Size, scale, size};
use raxel_terminal::session::What;

use super::presenting::{PresentWith, present_with};

/// The files that a window shows, and its settings.
#[derive(Clone, Debug, clap::Args)]
#[allow(clippy::struct_excessive_bools, reason = "each is an option of the command line")]
pub struct Args {
    /// The files to open.
    #[command(flatten)]
    pub what: What,

    /// The window's first size in pixels: the project's, or 1280x720 by default.
    #[arg(long, value_name = "WxH", value_parser = size)]
    pub size: Option<Size>,

    /// Pixels of the picture for each pixel of the window, along each axis: 0.5 computes a quarter of the pixels. The project's, or 1 by default.
    #[arg(long, value_name = "N", value_parser = scale)]
    pub scale: Option<f64>,

    /// Begin with the bare picture; F1 shows the panels.
    #[arg(long)]
    pub no_panels: bool,

    /// Quit after N frames.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    pub frames: Option<u64>,

    /// Show each picture as soon as it is ready, without waiting for the screen.
    #[arg(long)]
    pub no_vsync: bool,

    /// The device that draws the panels and presents the window: `own` for the one that renders, or a part of a name, or a number in `raxel doctor`.
    ///
    /// With another device, or the same GPU by its name, the panels answer while a slow pass runs. `own` is the default if that device is a GPU that
    /// can present to the window.
    #[arg(long, value_name = "own|DEVICE", value_parser = present_with)]
    pub present_with: Option<PresentWith>,

    /// Also check the files from time to time, for folders without change notifications (network folders).
    #[arg(long)]
    pub poll: bool,

    /// Listen to lines of JSON on stdin, and answer on stdout: docs/control.md.
    #[arg(long)]
    pub control: bool,
}

impl Args {
    /// The window's first size in pixels.
    pub(crate) fn first_size(&self) -> [u32; 2] {
        self.size.map_or([1280, 720], |size| size.0)
    }
}
