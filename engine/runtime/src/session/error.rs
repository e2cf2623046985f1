//! Why a session does not open, stops, or has no answer.

use raxel_diagnostics::{Diagnostic, SourceMap};
use raxel_execute::ExecuteError;

use crate::build_error::BuildError;
use crate::debug_target::DebugTargetError;
use crate::params::SetError;

/// Why a session does not open.
#[derive(Debug, thiserror::Error)]
pub enum OpenError {
    /// The project's files have mistakes.
    #[error("{}", first(.diagnostics))]
    Project {
        /// All mistakes, in all files.
        diagnostics: Vec<Diagnostic>,
        /// The texts that they point into.
        texts: Box<SourceMap>,
    },
    /// The graph does not have the debug target or a pinned resource.
    #[error(transparent)]
    DebugTarget(#[from] DebugTargetError),
    /// There is no suitable device, or the device refuses the plan.
    #[error(transparent)]
    Device(ExecuteError),
}

impl OpenError {
    /// Mistakes in files, and the texts that they point into.
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

/// Why a frame did not run.
#[derive(Debug, thiserror::Error)]
pub enum FrameError {
    /// No plan can be made for a new size, debug target or condition. One frame returns this error; later frames run the old plan.
    #[error("{}", first(.diagnostics))]
    Plan {
        /// The mistakes.
        diagnostics: Vec<Diagnostic>,
        /// The texts that they point into.
        texts: Box<SourceMap>,
    },
    /// The device failed, or was lost too often.
    #[error(transparent)]
    Device(ExecuteError),
}

/// Why something cannot be read back or selected.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    /// The graph does not have this name.
    #[error(transparent)]
    Unknown(#[from] SetError),
    /// The resource has no such part, or the device failed.
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
