//! Why a verb stops, and its exit code. The codes are a contract with scripts.

#[cfg(unix)]
use std::io::Write as _;
use std::process::ExitCode;

use raxel_output::OutputError;

/// Exit codes other than 0; 101 is a panic.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Exit {
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
pub struct Failure {
    /// The exit code.
    pub exit: Exit,
    /// The message; `None` when it was printed already.
    pub message: Option<String>,
    /// Advice, one piece each.
    pub help: Vec<String>,
    /// ffmpeg has ended, or refuses its input: the frames are sound where the film is not.
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
    #[must_use]
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

/// The result of a verb.
pub type Result<T = ()> = std::result::Result<T, Failure>;

/// Ends the process without the exit handlers of libraries. A driver's handler may wait for a device that never finishes. It may also
/// crash while another thread still works with the driver, which is usual within a verb.
#[cfg(unix)]
pub fn leave(code: u8) -> ! {
    // With stdout gone there is no reader left.
    let _ = std::io::stdout().flush();
    signal_hook::low_level::exit(code.into())
}

/// Ends the process.
#[cfg(not(unix))]
pub fn leave(code: u8) -> ! {
    std::process::exit(code.into())
}
