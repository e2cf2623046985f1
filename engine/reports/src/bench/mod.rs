//! `raxel bench`: measurements that anybody can repeat.

mod about;
mod chart;
mod demo;
mod export;
mod files;
mod film;
mod first_picture;
mod labels;
mod light;
mod matrix;
mod reload;
mod stream;
mod table;

use std::path::PathBuf;

use raxel_gpu::DeviceOptions;
use raxel_terminal::args::OnDevice;
use raxel_terminal::console::{Console, Format};
use raxel_terminal::failure::Result;

/// Measures graphs over layouts, worlds and cameras: GPU time, and how many of the same rays are wrong by exact arithmetic.
#[derive(Debug, clap::Args)]
#[command(
    args_conflicts_with_subcommands = true,
    after_help = "Examples:\n  raxel bench -o out/                                     everything, with CSV, JSON and charts\n  \
                  raxel bench first_hit --layouts tree64,svo              one graph over two layouts\n  \
                  raxel bench --worlds terrain --cameras ground,down --size 3840x2160\n  \
                  raxel bench --demo worlds/valley.demo.toml              a demo's frames and passes\n  \
                  raxel bench --export out/ --worlds menger               voxels, rays and hits for other tracers\n  \
                  raxel bench film worlds/valley.demo.toml --frames 240   what bounds the making of frames\n  \
                  raxel bench reload                                      from a save to the picture\n  \
                  raxel bench light -o out/                               lighting systems against a converged path tracer\n  \
                  raxel bench stream --world worlds/frontier.toml         a flight through a world while it loads"
)]
pub struct Args {
    #[command(subcommand)]
    what: Option<Bench>,

    /// Run all frames of this demo instead: times of passes and frames, and its checks of pass times.
    #[arg(
        long,
        value_name = "DEMO",
        conflicts_with_all = ["graphs", "layouts", "worlds", "cameras", "frames", "warmup", "seconds", "export"]
    )]
    demo: Option<PathBuf>,

    #[command(flatten)]
    matrix: matrix::Args,

    /// The device.
    #[command(flatten)]
    pub on: OnDevice,
}

#[derive(Debug, clap::Subcommand)]
enum Bench {
    Film(film::Args),
    Reload(reload::Args),
    Light(light::Args),
    Stream(stream::Args),
}

impl Args {
    /// Whether the time that compilers take is measured.
    pub fn measures_compilers(&self) -> bool {
        matches!(self.what, Some(Bench::Reload(_)))
    }

    /// The form of messages asked for.
    pub fn format(&self) -> Format {
        match &self.what {
            Some(Bench::Film(film)) => film.messages.format,
            Some(Bench::Reload(reload)) => reload.messages.format,
            Some(Bench::Light(light)) => light.messages.format,
            Some(Bench::Stream(stream)) => stream.messages.format,
            None => self.matrix.messages.format,
        }
    }
}

/// Runs the verb.
pub fn run(args: &Args, device: &DeviceOptions, console: &Console) -> Result {
    if let Some(demo) = &args.demo {
        return demo::run(demo, &args.matrix, device, console);
    }
    match &args.what {
        Some(Bench::Film(film)) => film::run(film, device, console),
        Some(Bench::Reload(reload)) => reload::run(reload, device, console),
        Some(Bench::Light(light)) => light::run(light, device, console),
        Some(Bench::Stream(stream)) => stream::run(stream, device, console),
        None => matrix::run(&args.matrix, device, console),
    }
}
