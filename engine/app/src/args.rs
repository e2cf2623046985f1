//! The command line as types: what every verb shares, and the list of verbs.

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

/// What to do.
#[derive(Debug, clap::Subcommand)]
pub(crate) enum Verb {
    Explain(verbs::explain::Args),
    Completions(verbs::completions::Args),
}

impl Verb {
    /// The form of messages that the verb was asked for.
    pub fn format(&self) -> Format {
        match self {
            Verb::Explain(args) => args.messages.format,
            Verb::Completions(_) => Format::Human,
        }
    }
}
