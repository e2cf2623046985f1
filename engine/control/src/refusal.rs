//! Why a request is refused.

use raxel_diagnostics::Diagnostic;
use raxel_diagnostics::names::{closest, list};
use raxel_output::OutputError;
use raxel_runtime::ReadError;
use raxel_runtime::session::EditFailure;
use raxel_terminal::failure::Failure;

/// Why a request was not done. Nothing has changed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Refusal {
    pub error: String,
    pub help: Vec<String>,
}

impl Refusal {
    pub(crate) fn new(error: impl Into<String>) -> Self {
        Self { error: error.into(), help: Vec::new() }
    }

    /// There is nothing of this name; the help has the name that was meant, or all.
    pub(crate) fn unknown<'n>(error: &str, name: &str, known: impl Iterator<Item = &'n str> + Clone) -> Self {
        let help = match closest(name, known.clone()) {
            Some(like) => Some(format!("did you mean `{like}`?")),
            None => (known.clone().next().is_some()).then(|| format!("it has {}", list(known))),
        };
        Self { error: format!("{error} `{name}`"), help: help.into_iter().collect() }
    }

    /// Only a window does it.
    pub(crate) fn no_window(request: &str) -> Self {
        let help = "`raxel run --control` opens a window".to_owned();
        Self { error: format!("`{request}` needs a window"), help: vec![help] }
    }

    /// With another way, without a window.
    pub(crate) fn or(mut self, instead: &str) -> Self {
        self.help.push(format!("without one, {instead}"));
        self
    }

    /// The session waits for the mend of its files.
    pub(crate) fn nothing_runs() -> Self {
        let help = "`diagnostics` lists them, and `wait_reload` waits until they are mended".to_owned();
        Self { error: "nothing runs, as the files have mistakes".to_owned(), help: vec![help] }
    }
}

impl From<Failure> for Refusal {
    fn from(failure: Failure) -> Self {
        Self { error: failure.message.unwrap_or_default(), help: failure.help }
    }
}

impl From<OutputError> for Refusal {
    fn from(error: OutputError) -> Self {
        Self { error: error.message, help: error.help }
    }
}

impl From<Vec<Diagnostic>> for Refusal {
    fn from(diagnostics: Vec<Diagnostic>) -> Self {
        let said: Vec<&str> = diagnostics.iter().map(|diagnostic| diagnostic.message.as_str()).collect();
        let error = said.join("; ");
        Self { error, help: diagnostics.into_iter().flat_map(|diagnostic| diagnostic.help).collect() }
    }
}

impl From<EditFailure> for Refusal {
    fn from(failure: EditFailure) -> Self {
        failure.into_diagnostics().into()
    }
}

macro_rules! refused_by {
    ($($error:ty),*) => {
        $(impl From<$error> for Refusal {
            fn from(error: $error) -> Self {
                Self::new(error.to_string())
            }
        })*
    };
}

refused_by!(
    ReadError,
    raxel_runtime::FrameError,
    raxel_runtime::session::CaptureError,
    raxel_runtime::params::SetError,
    raxel_runtime::take::TakeError,
    raxel_runtime::debug_target::DebugTargetError
);
