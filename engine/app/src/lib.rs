//! The raxel command line: one file a verb. Results go to stdout, messages to stderr.

#![cfg_attr(test, allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss))]

mod cli;
mod own_model;
mod panic;
mod templates;
mod unpacked;
mod verbs;

use std::process::ExitCode;

use clap::Parser;
use raxel_terminal::failure::leave;

/// Runs the command line of this process and gives its exit code (see [`raxel_terminal::failure::Exit`]).
pub fn main() -> ExitCode {
    if let Some(code) = raxel_shader::worker::isolate() {
        return code;
    }
    panic::install();
    raxel_output::watch_signals();
    let cli = cli::Cli::parse();
    let console = cli.console();
    let code = match cli.run(&console) {
        Ok(()) => 0,
        Err(failure) => {
            console.failure(&failure);
            failure.exit as u8
        }
    };
    if raxel_gpu::has_abandoned_device() {
        // A driver that waits for its device when the process ends would wait for ever.
        leave(code);
    }
    code.into()
}
