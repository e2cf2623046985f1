//! Why a picture, a film or a table could not be written.

use std::fmt;

/// A file or a stream that could not be written, or an argument that does not say what to write.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OutputError {
    /// What is wrong, with the path.
    pub message: String,
    /// What to do about it, one piece of advice each.
    pub help: Vec<String>,
    /// ffmpeg has ended, or refuses what it is given: the frames are sound where the film is not.
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

/// What writing gives.
pub type Result<T = ()> = std::result::Result<T, OutputError>;
