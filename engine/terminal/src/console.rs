//! The output of a verb: results on stdout, messages on stderr, in the requested form.

use std::fmt::Write as _;
use std::io::{ErrorKind, IsTerminal, Write};
use std::path::Path;

use raxel_diagnostics::{Diagnostic, SourceMap, render};
use serde_json::{Value, json};

use crate::failure::{Exit, Failure, leave};
use crate::program::Program;

/// The form of messages.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Format {
    /// With the lines of the files.
    Human,
    /// One line each, `path:line:column: error[CODE]: message`, for editors.
    Short,
    /// One JSON object a line.
    Json,
}

/// When to colour.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Color {
    /// On a terminal that can.
    Auto,
    /// Always.
    Always,
    /// Never.
    Never,
}

/// A path as a word of a command line that a message proposes: quoted where a shell would take it apart.
pub fn word(path: &Path) -> String {
    let text = path.display().to_string();
    shlex::try_quote(&text).map(String::from).unwrap_or(text)
}

/// Where a message goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum To {
    /// The verb's own result.
    Stdout,
    /// Messages about it.
    Stderr,
}

/// The output of a verb.
#[derive(Clone, Debug)]
pub struct Console {
    format: Format,
    color: Color,
    verbose: bool,
    program: Option<Program>,
}

impl Console {
    /// As the command line asks.
    pub fn new(format: Format, color: Color, verbose: bool) -> Self {
        Self { format, color, verbose, program: None }
    }

    /// For a program that drives the verb by lines of JSON.
    #[must_use]
    pub fn driven(self, program: Option<Program>) -> Self {
        Self { program, ..self }
    }

    /// The program that drives the verb, and reads events from stdout.
    pub fn program(&self) -> Option<&Program> {
        self.program.as_ref()
    }

    /// Waits until a program that drives the verb has read all that was sent.
    pub fn finish(&self) {
        if let Some(program) = &self.program {
            program.finish();
        }
    }

    /// The form asked for.
    pub fn format(&self) -> Format {
        self.format
    }

    /// Whether more was asked for.
    pub fn verbose(&self) -> bool {
        self.verbose
    }

    /// Whether to colour that stream.
    pub fn colored(&self, to: To) -> bool {
        match self.color {
            Color::Always => true,
            Color::Never => false,
            Color::Auto => {
                let choice = match to {
                    To::Stdout => anstream::AutoStream::choice(&std::io::stdout()),
                    To::Stderr => anstream::AutoStream::choice(&std::io::stderr()),
                };
                choice != anstream::ColorChoice::Never
            }
        }
    }

    /// Whether somebody watches stderr, for progress.
    pub fn watched(&self) -> bool {
        self.format == Format::Human && std::io::stderr().is_terminal()
    }

    /// A message.
    pub fn message(&self, text: &str) {
        match self.format {
            Format::Json => write(To::Stderr, &format!("{}\n", json!({ "reason": "message", "message": text }))),
            _ => write(To::Stderr, &format!("{text}\n")),
        }
    }

    /// A message for `--verbose`.
    pub fn detail(&self, text: &str) {
        if self.verbose {
            self.message(text);
        }
    }

    /// Diagnostics in the form asked for.
    pub fn diagnostics(&self, diagnostics: &[Diagnostic], texts: &SourceMap, to: To) {
        if diagnostics.is_empty() {
            return;
        }
        let text = match self.format {
            Format::Human => render::human(diagnostics, texts, self.colored(to)),
            Format::Short => render::short(diagnostics, texts),
            Format::Json => render::json(diagnostics, texts),
        };
        write(to, &text);
    }

    /// Shows diagnostics that point into no file and gives the failure they mean.
    pub fn stop(&self, diagnostics: &[Diagnostic]) -> Failure {
        self.stop_in(diagnostics, &SourceMap::default())
    }

    /// Shows diagnostics and gives the failure they mean.
    pub fn stop_in(&self, diagnostics: &[Diagnostic], texts: &SourceMap) -> Failure {
        self.diagnostics(diagnostics, texts, To::Stderr);
        Failure::printed(Exit::Project)
    }

    /// Why a verb stops.
    pub fn failure(&self, failure: &Failure) {
        let Some(message) = &failure.message else { return };
        if self.format == Format::Json {
            let value =
                json!({ "reason": "failure", "exit": failure.exit as u8, "message": message, "help": failure.help });
            return write(To::Stderr, &format!("{value}\n"));
        }
        let (red, cyan, plain) =
            if self.colored(To::Stderr) { ("\x1b[1;31m", "\x1b[1;36m", "\x1b[0m") } else { ("", "", "") };
        let mut text = format!("{red}error{plain}: {message}\n");
        for help in &failure.help {
            let _ = writeln!(text, "{cyan}help{plain}: {help}");
        }
        write(To::Stderr, &text);
    }
}

/// The result of a verb, as it is. A reader that went away (`| head`) ends the process quietly.
pub fn data(text: &str) {
    write(To::Stdout, text);
}

/// A result as one line of JSON.
pub fn json(value: &Value) {
    write(To::Stdout, &format!("{value}\n"));
}

/// Something that happened, as one line of JSON among the messages.
pub fn event(value: &Value) {
    write(To::Stderr, &format!("{value}\n"));
}

fn write(to: To, text: &str) {
    let result = match to {
        To::Stdout => {
            let mut out = std::io::stdout().lock();
            out.write_all(text.as_bytes()).and_then(|()| out.flush())
        }
        To::Stderr => std::io::stderr().lock().write_all(text.as_bytes()),
    };
    match result {
        Err(error) if to == To::Stdout => unwritable(&error),
        // With stderr gone there is no reader left.
        _ => {}
    }
}

/// Ends the process after a failed write to stdout.
pub(crate) fn unwritable(error: &std::io::Error) -> ! {
    if error.kind() == ErrorKind::BrokenPipe {
        leave(0);
    }
    eprintln!("error: stdout cannot be written: {error}");
    leave(Exit::Usage as u8);
}
