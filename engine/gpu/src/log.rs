//! Messages of the validation layer, kept so that tests and `raxel` itself can ask for them.

use std::sync::Mutex;

/// How bad a message is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// Likely wrong.
    Warning,
    /// Wrong.
    Error,
}

/// One message.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Message {
    /// How bad it is.
    pub severity: Severity,
    /// The layer's name for the kind of message, e.g. `SYNC-HAZARD-READ-AFTER-WRITE`.
    pub id: String,
    /// The whole text.
    pub text: String,
}

/// At most this many texts are kept; all are counted.
const KEPT: usize = 256;

/// Collects what the validation layer says. Shared by every thread that calls Vulkan.
#[derive(Debug, Default)]
pub struct ValidationLog {
    state: Mutex<State>,
}

#[derive(Debug, Default)]
struct State {
    messages: Vec<Message>,
    errors: u64,
    warnings: u64,
}

impl ValidationLog {
    pub(crate) fn push(&self, message: Message) {
        let mut state = self.lock();
        match message.severity {
            Severity::Warning => state.warnings += 1,
            Severity::Error => state.errors += 1,
        }
        if state.messages.len() < KEPT {
            state.messages.push(message);
        }
    }

    /// Number of errors and of warnings so far, `take`n ones included.
    pub fn counts(&self) -> (u64, u64) {
        let state = self.lock();
        (state.errors, state.warnings)
    }

    /// A copy of the messages that were not taken yet.
    pub fn messages(&self) -> Vec<Message> {
        self.lock().messages.clone()
    }

    /// Removes and returns the messages.
    pub fn take(&self) -> Vec<Message> {
        std::mem::take(&mut self.lock().messages)
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, State> {
        // A panic elsewhere leaves whole messages behind; they stay worth reading.
        self.state.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
    }
}
