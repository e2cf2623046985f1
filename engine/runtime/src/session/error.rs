//! Why a session does not open, stops, or has no answer.

use raxel_diagnostics::{Diagnostic, SourceMap};
use raxel_execute::ExecuteError;

use crate::build_error::BuildError;
use crate::debug_target::DebugTargetError;
use crate::params::SetError;

/// Why a session does not open.
#[derive(Debug, thiserror::Error)]
pub enum OpenError {
    /// The project's files are wrong.
    #[error("{}", first(.diagnostics))]
    Project {
        /// Everything that is wrong, in all files.
        diagnostics: Vec<Diagnostic>,
        /// The texts that they point into.
        texts: Box<SourceMap>,
    },
    /// The debug target or a pinned resource is not the graph's.
    #[error(transparent)]
    DebugTarget(#[from] DebugTargetError),
    /// There is no device, or it refuses.
    #[error(transparent)]
    Device(ExecuteError),
}

impl OpenError {
    /// What is wrong with files, and the texts that this points into.
    pub(super) fn of_files((diagnostics, texts): (Vec<Diagnostic>, SourceMap)) -> Self {
        Self::Project { diagnostics, texts: Box::new(texts) }
    }
}

impl From<BuildError> for OpenError {
    fn from(error: BuildError) -> Self {
        match error {
            BuildError::Diagnosed(diagnostics) => Self::Project { diagnostics, texts: Box::default() },
            BuildError::Device(error) => Self::Device(error),
        }
    }
}

impl From<Box<Diagnostic>> for OpenError {
    fn from(diagnostic: Box<Diagnostic>) -> Self {
        Self::Project { diagnostics: vec![*diagnostic], texts: Box::default() }
    }
}

impl From<raxel_gpu::Error> for OpenError {
    fn from(error: raxel_gpu::Error) -> Self {
        Self::Device(error.into())
    }
}

impl From<ExecuteError> for OpenError {
    fn from(error: ExecuteError) -> Self {
        Self::Device(error)
    }
}

/// Why there is no frame.
#[derive(Debug, thiserror::Error)]
pub enum FrameError {
    /// The plan for a new size, debug target or condition cannot be made. It is said once, and the plan before runs on.
    #[error("{}", first(.diagnostics))]
    Plan {
        /// What is in the way.
        diagnostics: Vec<Diagnostic>,
        /// The texts that they point into.
        texts: Box<SourceMap>,
    },
    /// The device fails, or was lost too often.
    #[error(transparent)]
    Device(ExecuteError),
}

/// Why something cannot be read back or chosen.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    /// A name that the graph does not have.
    #[error(transparent)]
    Unknown(#[from] SetError),
    /// The resource, or the device, has no such thing to give.
    #[error(transparent)]
    Execute(#[from] ExecuteError),
}

fn first(diagnostics: &[Diagnostic]) -> String {
    let errors = || diagnostics.iter().filter(|diagnostic| diagnostic.is_error());
    match (errors().next(), errors().count()) {
        (None, _) => "nothing is wrong".to_owned(),
        (Some(first), 1) => format!("[{}] {}", first.code, first.message),
        (Some(first), count) => format!("[{}] {} (and {} more)", first.code, first.message, count - 1),
    }
}
