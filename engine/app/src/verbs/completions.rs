//! `raxel completions SHELL`: a completion script on stdout.

use raxel_terminal::console;

/// Prints a script that completes raxel's command line.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example: raxel completions bash > ~/.local/share/bash-completion/completions/raxel")]
pub(crate) struct Args {
    /// The shell.
    shell: clap_complete::Shell,
}

pub(crate) fn run(args: &Args, command: &mut clap::Command) {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, command, "raxel", &mut script);
    console::data(&String::from_utf8_lossy(&script));
}
