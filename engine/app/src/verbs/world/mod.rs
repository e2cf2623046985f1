//! `raxel world`: what a world is made of, models in and out, saves, and stores.

mod bake;
mod export;
pub(crate) mod import;
mod info;
mod save;

pub(crate) use info::bytes;

use raxel_terminal::args::Messages;
use raxel_terminal::console::{Console, Format};
use raxel_terminal::failure::Result;

/// Inspects worlds and their saves, imports and exports MagicaVoxel .vox files, bakes worlds into stores.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    #[command(subcommand)]
    action: Action,
}

#[derive(Debug, clap::Subcommand)]
enum Action {
    Info(info::Args),
    Import(import::Args),
    Export(export::Args),
    Bake(bake::Args),
    Save(save::Save),
    Verify(save::Verify),
    Compact(save::Compact),
    Pack(save::Pack),
}

impl Args {
    /// The form of messages asked for.
    pub(crate) fn format(&self) -> Format {
        let Messages { format } = match &self.action {
            Action::Info(args) => args.messages,
            Action::Import(args) => args.messages,
            Action::Export(args) => args.messages,
            Action::Bake(args) => args.messages,
            Action::Save(args) => args.messages(),
            Action::Verify(args) => args.messages(),
            Action::Compact(args) => args.messages(),
            Action::Pack(args) => args.messages(),
        };
        format
    }
}

pub(crate) fn run(args: &Args, console: &Console) -> Result {
    match &args.action {
        Action::Info(args) => info::run(args, console),
        Action::Import(args) => import::run(args, console),
        Action::Export(args) => export::run(args, console),
        Action::Bake(args) => bake::run(args, console),
        Action::Save(args) => args.run(console),
        Action::Verify(args) => args.run(console),
        Action::Compact(args) => args.run(console),
        Action::Pack(args) => args.run(console),
    }
}
