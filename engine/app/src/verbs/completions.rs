//! `raxel completions SHELL`: a completion script on stdout.

use clap::CommandFactory;

use crate::args::Cli;
use crate::talk;

/// Prints a script that completes raxel's command line.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example: raxel completions bash > ~/.local/share/bash-completion/completions/raxel")]
pub(crate) struct Args {
    /// The shell.
    shell: clap_complete::Shell,
}

pub(crate) fn run(args: &Args) {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut Cli::command(), "raxel", &mut script);
    talk::data(&String::from_utf8_lossy(&script));
}
