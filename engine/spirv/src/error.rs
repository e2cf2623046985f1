//! Why a module is not taken.

/// Why a module is not taken.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ModuleError {
    /// Not well formed.
    #[error("{0}")]
    Broken(String),
    /// Well formed as far as can be seen, but not for raxel.
    #[error("{0}")]
    Unsupported(String),
    /// Threads with more variables than fit anywhere.
    #[error("the variables of each thread take {bytes} bytes")]
    TooMuch {
        /// Their size.
        bytes: u64,
        /// The largest size.
        limit: u64,
    },
    /// There is no such entry point; the second value lists the existing ones.
    #[error("there is no compute entry point `{entry}`")]
    NoEntry {
        /// The requested entry point.
        entry: String,
        /// The module's entry points, with their kinds.
        found: Vec<String>,
    },
}

pub(crate) fn broken<T>(reason: impl Into<String>) -> Result<T, ModuleError> {
    Err(ModuleError::Broken(reason.into()))
}
