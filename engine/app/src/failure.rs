//! Why a verb stops, and the exit code that says so. The codes are a contract with scripts.

use std::process::ExitCode;

use raxel_output::OutputError;

/// Exit codes other than 0; 101 is a panic.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Exit {
    /// Something that was asked to be checked does not hold.
    Check = 1,
    /// The command line is wrong, or an output cannot be written.
    Usage = 2,
    /// A graph, shader, world or demo has errors.
    Project = 3,
    /// No suitable Vulkan device.
    NoDevice = 4,
    /// The device was lost or did not answer in time.
    DeviceLost = 5,
    /// The validation layer had something to say.
    Validation = 6,
}

impl From<Exit> for ExitCode {
    fn from(exit: Exit) -> Self {
        ExitCode::from(exit as u8)
    }
}

/// Why a verb stops. `message` is `None` when the diagnostics were printed already.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Failure {
    pub exit: Exit,
    pub message: Option<String>,
    pub help: Vec<String>,
    /// ffmpeg has ended, or refuses what it is given: the frames are sound where the film is not.
    pub ffmpeg: bool,
}

impl Failure {
    /// Stops with a message.
    pub fn new(exit: Exit, message: impl Into<String>) -> Self {
        Self { exit, message: Some(message.into()), help: Vec::new(), ffmpeg: false }
    }

    /// Stops; the diagnostics were printed already.
    pub fn printed(exit: Exit) -> Self {
        Self { exit, message: None, help: Vec::new(), ffmpeg: false }
    }

    /// A wrong command line.
    pub fn usage(message: impl Into<String>) -> Self {
        Self::new(Exit::Usage, message)
    }

    /// Adds advice.
    pub fn help(mut self, help: impl Into<String>) -> Self {
        self.help.push(help.into());
        self
    }
}

impl From<OutputError> for Failure {
    fn from(error: OutputError) -> Self {
        Self { exit: Exit::Usage, message: Some(error.message), help: error.help, ffmpeg: error.ffmpeg }
    }
}

/// What a verb gives.
pub(crate) type Result<T = ()> = std::result::Result<T, Failure>;
