//! The raxel command line: one file a verb, and the window. Results go to stdout, messages to stderr.

mod args;
mod cache;
mod cli;
mod console;
mod control;
mod device;
mod failure;
mod front;
mod journal;
mod output;
mod panic;
mod session;
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
    let cli = cli::Cli::parse();
    let console = cli.console();
    match cli.run(&console) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            console.failure(&failure);
            failure.exit.into()
        }
    }
}
