//! The command line as types: what every verb shares, and the list of verbs.

use raxel_runtime::present::Viewport;

use crate::talk::{Color, Format};
use crate::verbs;

/// A live, data-driven Vulkan render graph over voxel worlds.
#[derive(Debug, clap::Parser)]
#[command(
    name = "raxel",
    version,
    arg_required_else_help = true,
    disable_help_subcommand = false,
    after_help = "Examples:\n  raxel run                                        the project's graph and world in a window\n  \
                  raxel run worlds/valley.demo.toml                a demo\n  \
                  raxel render graphs/primary.toml -o a.png        one picture, without a window\n  \
                  raxel check graphs/*.toml                        every mistake in every graph, without a GPU\n\n\
                  Exit codes: 0 ok, 1 a check failed, 2 usage, 3 graph, shader or world error, 4 no suitable device,\n\
                  5 device lost or timed out, 6 a validation message, 101 a bug in raxel"
)]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub verb: Verb,

    /// When to colour messages; NO_COLOR and CLICOLOR_FORCE are honoured.
    #[arg(long, global = true, value_enum, default_value_t = Color::Auto, value_name = "WHEN")]
    pub color: Color,

    /// The Vulkan device: a part of its name, or its number in `raxel doctor`.
    #[arg(long, global = true, value_name = "DEVICE")]
    pub device: Option<String>,

    /// Run with the Vulkan validation layer, synchronization checks included; any message makes the exit code 6.
    #[arg(long, global = true)]
    pub validate: bool,

    /// Say more: the device chosen and why, what is compiled, what is reused.
    #[arg(long, short, global = true)]
    pub verbose: bool,
}

/// The form of messages and of what a verb prints.
#[derive(Clone, Copy, Debug, clap::Args)]
pub(crate) struct Messages {
    /// The form of messages and results.
    #[arg(long, value_enum, default_value_t = Format::Human)]
    pub format: Format,
}

/// An extent in pixels, both sides at least 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Size(pub [u32; 2]);

/// Reads a scale of the output, such as `0.5`.
pub(crate) fn scale(text: &str) -> Result<f64, String> {
    let scales = Viewport::SCALES;
    text.parse()
        .ok()
        .filter(|scale| scales.contains(scale))
        .ok_or_else(|| format!("write a number from {} to {}, e.g. 0.5", scales.start(), scales.end()))
}

/// Reads `640x360`.
pub(crate) fn size(text: &str) -> Result<Size, String> {
    const LARGEST: u32 = 16384;
    let side = |side: &str| side.parse().ok().filter(|n| (1..=LARGEST).contains(n));
    text.split_once(['x', 'X', '×'])
        .and_then(|(width, height)| Some(Size([side(width)?, side(height)?])))
        .ok_or_else(|| format!("write WIDTHxHEIGHT with sides of 1 to {LARGEST} pixels, e.g. 640x360"))
}

/// What is named twice is meant once. The first place counts.
pub(crate) fn each_once<T: PartialEq>(named: Vec<T>) -> Vec<T> {
    let mut once = Vec::with_capacity(named.len());
    for name in named {
        if !once.contains(&name) {
            once.push(name);
        }
    }
    once
}

/// What to do.
#[derive(Debug, clap::Subcommand)]
pub(crate) enum Verb {
    Run(verbs::run::Args),
    Render(verbs::render::Args),
    Check(verbs::check::Args),
    Graph(verbs::graph::Args),
    World(verbs::world::Args),
    Shaders(verbs::shaders::Args),
    New(verbs::new::Args),
    Schema(verbs::schema::Args),
    Bench(verbs::bench::Args),
    Stress(verbs::stress::Args),
    Doctor(verbs::doctor::Args),
    Explain(verbs::explain::Args),
    Clean(verbs::clean::Args),
    Completions(verbs::completions::Args),
}

impl Verb {
    /// The form of messages that the verb was asked for.
    pub fn format(&self) -> Format {
        match self {
            Verb::Run(args) => args.messages.format,
            Verb::Render(args) => args.messages.format,
            Verb::Check(args) => args.messages.format,
            Verb::Graph(args) if args.format == verbs::graph::Form::Json => Format::Json,
            Verb::World(args) => args.format(),
            Verb::Shaders(args) => args.messages.format,
            Verb::New(args) => args.messages.format,
            Verb::Bench(args) => args.format(),
            Verb::Stress(args) => args.format(),
            Verb::Doctor(args) => args.messages.format,
            Verb::Explain(args) => args.messages.format,
            Verb::Clean(args) => args.messages.format,
            Verb::Graph(_) | Verb::Schema(_) | Verb::Completions(_) => Format::Human,
        }
    }
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    use super::*;

    #[test]
    fn the_command_line_is_consistent() {
        Cli::command().debug_assert();
    }

    #[test]
    fn sizes() {
        assert_eq!(size("640x360"), Ok(Size([640, 360])));
        for wrong in ["", "640", "0x1", "-1x5", "1x2x3", "99999x1", "a x b"] {
            assert!(size(wrong).is_err(), "{wrong}");
        }
    }
}
