//! Why a picture, a film or a table could not be written.

use std::fmt;

/// Why an output could not be written, or the fault of the argument that names it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OutputError {
    /// The message, with the path.
    pub message: String,
    /// Advice, one suggestion each.
    pub help: Vec<String>,
    /// Whether ffmpeg failed. Then the frames are good, but the film is not.
    pub ffmpeg: bool,
}

impl OutputError {
    pub(crate) fn new(message: impl Into<String>) -> Self {
        Self { message: message.into(), help: Vec::new(), ffmpeg: false }
    }

    pub(crate) fn help(mut self, help: impl Into<String>) -> Self {
        self.help.push(help.into());
        self
    }
}

impl fmt::Display for OutputError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

impl std::error::Error for OutputError {}

/// The result of writing.
pub type Result<T = ()> = std::result::Result<T, OutputError>;
