//! Why a graph cannot run on a device: apart from building, since sources say it too.

use raxel_diagnostics::{Diagnostic, codes};
use raxel_execute::ExecuteError;

/// Why a graph cannot run on this device.
#[derive(Debug)]
pub enum BuildError {
    /// The author can change something about it.
    Diagnosed(Vec<Diagnostic>),
    /// The device fails.
    Device(ExecuteError),
}

impl BuildError {
    /// The error as a diagnostic for the author.
    pub fn into_diagnostics(self) -> Vec<Diagnostic> {
        match self {
            Self::Diagnosed(diagnostics) => diagnostics,
            Self::Device(error) => vec![Diagnostic::error(codes::session::DEVICE_REFUSES, error.to_string())],
        }
    }
}
