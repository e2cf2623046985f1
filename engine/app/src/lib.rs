//! The raxel command line: one file a verb. Results go to stdout, messages to stderr.
//!
//! A part of raxel. Programs use the crate `raxel`; this one may change in any release.

#![cfg_attr(test, allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss))]

mod cli;
mod own_model;
mod panic;
mod templates;
mod unpacked;
mod verbs;

use std::ffi::OsString;
use std::io::ErrorKind;
use std::process::ExitCode;

use clap::Parser;
use raxel_terminal::failure::{Exit, leave};

/// Runs the command line of this process and gives its exit code (see [`raxel_terminal::failure::Exit`]).
pub fn main() -> ExitCode {
    if let Some(code) = raxel_shader::worker::isolate() {
        return code;
    }
    panic::install();
    raxel_output::watch_signals();
    let cli = match cli::Cli::try_parse_from(arguments(std::env::args_os())) {
        Ok(cli) => cli,
        Err(error) => return tell(&error),
    };
    let console = cli.console();
    let code = match cli.run(&console) {
        Ok(()) => 0,
        Err(failure) => {
            console.failure(&failure);
            failure.exit as u8
        }
    };
    console.finish();
    if raxel_gpu::has_abandoned_device() {
        // A driver that waits for its device when the process ends would wait for ever.
        leave(code);
    }
    code.into()
}

/// The arguments without a `--help` behind `raxel help`, which clap takes for the name of a verb.
fn arguments(given: impl Iterator<Item = OsString>) -> impl Iterator<Item = OsString> {
    let mut is_help = false;
    given.enumerate().filter_map(move |(index, argument)| {
        is_help |= index == 1 && argument == "help";
        (!is_help || (argument != "--help" && argument != "-h")).then_some(argument)
    })
}

/// Prints clap's answer if there is no command: a help, the version, or an error about the arguments.
fn tell(instead: &clap::Error) -> ExitCode {
    match instead.print() {
        Err(error) if !instead.use_stderr() && error.kind() != ErrorKind::BrokenPipe => {
            eprintln!("error: stdout cannot be written: {error}");
            ExitCode::from(Exit::Usage as u8)
        }
        _ => ExitCode::from(u8::try_from(instead.exit_code()).unwrap_or(Exit::Usage as u8)),
    }
}
