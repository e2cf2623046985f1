//! The raxel command line: one file a verb, and the window. Data goes to stdout, talk to stderr.

mod args;
mod device;
mod failure;
mod front;
mod output;
mod panic;
mod session;
mod talk;
mod verbs;
mod viewer;

use std::process::ExitCode;

use clap::Parser;

/// Runs the command line of this process and gives its exit code (see [`failure::Exit`]).
pub fn main() -> ExitCode {
    if let Some(code) = raxel_shader::worker::isolate() {
        return code;
    }
    panic::install();
    output::watch_signals();
    let cli = args::Cli::parse();
    let talk = talk::Talk::new(&cli);
    match verbs::run(cli, &talk) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            talk.failure(&failure);
            failure.exit.into()
        }
    }
}
