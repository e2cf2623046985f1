//! `raxel demo`: a demo that raxel ships, in a window, or as a picture and a film where there is no display.

use std::path::{Path, PathBuf};
use std::time::Duration;

use raxel_diagnostics::names;
use raxel_gpu::{Device, DeviceKind, DeviceOptions, Validation};
use raxel_output::{Folders, Output, ffmpeg_version};
use raxel_runtime::project::Project;
use raxel_terminal::args::{Messages, OnDevice, Size, scale, size};
use raxel_terminal::console::{self, Console};
use raxel_terminal::failure::{Exit, Failure, Result};
use raxel_terminal::session::{Eye, What, seconds};
use raxel_window as window;

use super::render;
use crate::unpacked::Unpacked;

/// Shows a demo that raxel ships: in a window, or as a picture and a film if there is no display.
///
/// It needs no project and no network.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  raxel demo\n  raxel demo fair --size 640x360\n  raxel demo valley --no-window -o pictures\n\n\
                        The film needs ffmpeg; without it, the frames of the film are written as PNG files."
)]
pub(crate) struct Args {
    /// Its name, e.g. `valley`, or a file *.demo.toml. The demo of the project around the current folder is taken before raxel's own.
    #[arg(value_name = "DEMO", default_value = "dusk")]
    demo: String,

    /// Write a picture and a film even where there is a display.
    #[arg(long)]
    no_window: bool,

    /// The folder for the picture and the film: `.raxel/demo` in the project of the demo, or `raxel-demo` here by default.
    #[arg(short, long, value_name = "FOLDER")]
    output: Option<PathBuf>,

    /// Pixels of the window, the picture and the film. By default 960x540, and 320x180 for the film.
    #[arg(long, value_name = "WxH", value_parser = size)]
    size: Option<Size>,

    /// Pixels of the picture for each pixel of the window, along each axis: 0.5 computes a quarter of the pixels. By default 1, or 0.25 where
    /// the CPU computes them.
    #[arg(long, value_name = "N", value_parser = scale)]
    scale: Option<f64>,

    /// Frames a second of the film. The demo's by default, or 15 where the CPU computes them.
    #[arg(long, value_name = "RATE", value_parser = render::rate)]
    fps: Option<f64>,

    /// Quit after N frames; the film has as many.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    frames: Option<u64>,

    /// Set a param; may be repeated.
    #[arg(long, value_name = "NAME=VALUE")]
    set: Vec<String>,

    /// Seconds without a finished pass after which a frame counts as hung, and is given up; six times as many on a software device, where
    /// Linux counts processor time.
    #[arg(long, value_name = "SECONDS", default_value = "10", value_parser = seconds)]
    watchdog: Duration,

    #[command(flatten)]
    pub messages: Messages,

    #[command(flatten)]
    pub on: OnDevice,
}

pub(crate) fn run(args: &Args, device: &DeviceOptions, console: &Console) -> Result {
    if let Some(folder) = args.output.as_deref().filter(|path| path.extension().is_some() && !path.is_dir()) {
        let message = format!("`-o {}`: a demo writes a picture and a film into a folder", folder.display());
        return Err(Failure::usage(message).help("`raxel render DEMO -o FILE` writes one file"));
    }
    let found = Found::new(&args.demo, console)?;
    let software = {
        let probe = DeviceOptions { validation: Validation::Off, ..device.clone() };
        Device::new(&probe)?.capabilities().kind == DeviceKind::Cpu
    };
    if !args.no_window && has_display() {
        match args.show(&found, software, device, console) {
            Err(failure) if failure.exit == Exit::NoDevice => {
                console.message(&failure.message.unwrap_or_default());
                console.message("rendering a picture and a film instead");
            }
            result => return result,
        }
    }
    args.write(&found, software, device, console)
}

/// Whether a window can be asked for.
fn has_display() -> bool {
    let set = |name| std::env::var_os(name).is_some_and(|value| !value.is_empty());
    cfg!(any(windows, target_os = "macos")) || set("DISPLAY") || set("WAYLAND_DISPLAY")
}

/// A demo, and where its pictures go.
struct Found {
    demo: PathBuf,
    /// Of the file, without `.demo.toml`.
    name: String,
    output: PathBuf,
    /// The project that the demo lies in, if it is raxel's own.
    unpacked: Option<Unpacked>,
}

impl Found {
    fn new(wanted: &str, console: &Console) -> Result<Self> {
        const ENDING: &str = ".demo.toml";
        let named = Path::new(wanted);
        let project = Project::around(Path::new(".")).ok();
        let here = || PathBuf::from("raxel-demo");
        let file_name = named.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
        if wanted.ends_with(ENDING) {
            if !named.is_file() {
                return Err(Failure::new(Exit::Project, format!("there is no `{wanted}`")));
            }
            let project = Project::around_file(named).ok().filter(|_| Project::around(named).is_ok());
            let output = project.map_or_else(here, |project| project.root().join(".raxel/demo"));
            let name = file_name.trim_end_matches(ENDING).to_owned();
            return Ok(Self { demo: named.to_owned(), name, output, unpacked: None });
        }
        let path = format!("worlds/{wanted}{ENDING}");
        if let Some(project) = project
            && project.on_disk(&path).is_file()
        {
            let (demo, output) = (project.on_disk(&path), project.root().join(".raxel/demo"));
            return Ok(Self { demo, name: wanted.to_owned(), output, unpacked: None });
        }
        if raxel_shipped::file(&path).is_none() {
            let name = |path: &'static str| path.strip_prefix("worlds/")?.strip_suffix(ENDING);
            let shipped = || raxel_shipped::FILES.iter().filter_map(|(path, _)| name(path));
            let help = match names::closest(wanted, shipped()) {
                Some(close) => format!("did you mean `{close}`?"),
                None => format!("there are {}; or name a file *.demo.toml", names::list(shipped())),
            };
            return Err(Failure::new(Exit::Project, format!("there is no demo `{wanted}`")).help(help));
        }
        let unpacked = Unpacked::new(console)?;
        let demo = unpacked.root().join(path);
        Ok(Self { demo, name: wanted.to_owned(), output: here(), unpacked: Some(unpacked) })
    }
}

impl Args {
    fn what(&self, demo: &Path) -> What {
        What {
            file: Some(demo.to_owned()),
            world: None,
            target: None,
            after: None,
            set: self.set.clone(),
            eye: Eye::default(),
            check_bounds: false,
            watchdog: self.watchdog,
        }
    }

    fn show(&self, found: &Found, software: bool, device: &DeviceOptions, console: &Console) -> Result {
        let own_size = self.size.is_none() && self.scale.is_none();
        if software && own_size {
            console.message("no GPU: computing 240×135 pixels for a window of 960×540; `--scale 0.5` computes more");
        }
        if let Some(unpacked) = found.unpacked.as_ref().filter(|unpacked| unpacked.stays()) {
            console.message(&format!("edit the demo's files while it runs: they are in {}", unpacked.root().display()));
        }
        let args = window::Args {
            what: self.what(&found.demo),
            size: self.size.or(own_size.then_some(Size([960, 540]))),
            scale: self.scale.or((software && own_size).then_some(0.25)),
            no_panels: false,
            frames: self.frames,
            no_vsync: false,
            present_with: None,
            poll: false,
            control: false,
        };
        window::run(&args, device, console)
    }

    fn write(&self, found: &Found, software: bool, device: &DeviceOptions, console: &Console) -> Result {
        let folder = self.output.as_ref().unwrap_or(&found.output);
        let made = Folders::make(folder).map_err(|error| Failure::from(error).help("`-o FOLDER` names another one"))?;
        let what = self.what(&found.demo);
        let render = |output: &Path, size: [u32; 2]| {
            let mut args =
                render::Args::new(what.clone(), output.display().to_string(), self.messages, self.on.clone());
            args.size = Some(self.size.unwrap_or(Size(size)));
            args
        };
        // Of the first moment: later ones build on all frames before them. Graphs that average over time get some frames of it.
        let mut picture = render(&folder.join(format!("{}.png", found.name)), [960, 540]);
        picture.at = Some(0.0);
        picture.settle = 8;
        render::run(&picture, device, console)?;

        let film = folder.join(format!("{}.mp4", found.name));
        let with_ffmpeg = ffmpeg_version().is_some();
        let frames = Output::frames_of(&film);
        let output = if with_ffmpeg {
            film.clone()
        } else {
            console.message("no film: ffmpeg is not installed; writing its frames instead");
            frames.clear()?;
            frames.describe().into()
        };
        let fps = self.fps.or(software.then_some(15.0)).or(what.demo().map(|demo| demo.fps));
        let mut film_args = render(&output, [320, 180]);
        film_args.fps = fps;
        film_args.frames = self.frames;
        render::run(&film_args, device, console)?;
        made.keep();
        if !with_ffmpeg {
            let rate = fps.map_or(String::new(), |fps| format!(" --fps {fps}"));
            let (from, to) = (console::word(&output), console::word(&film));
            console.message(&format!("where ffmpeg is: raxel film {from}{rate} -o {to}"));
        }
        console.message("for a window, set DISPLAY or WAYLAND_DISPLAY (a desktop, or ssh -X)");
        console.message("for a project of your own: raxel new my-voxels --template beauty");
        Ok(())
    }
}
