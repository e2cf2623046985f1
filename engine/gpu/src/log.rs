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

/// At most this many messages are kept.
const KEPT: usize = 256;

/// Collects the messages of the validation layer. Shared by every thread that calls Vulkan.
#[derive(Debug, Default)]
pub struct ValidationLog {
    messages: Mutex<Vec<Message>>,
}

impl ValidationLog {
    pub(crate) fn push(&self, message: Message) {
        let mut messages = self.lock();
        if messages.len() < KEPT {
            messages.push(message);
        }
    }

    /// A copy of the messages that were not taken yet.
    pub fn messages(&self) -> Vec<Message> {
        self.lock().clone()
    }

    /// Removes and returns the messages.
    pub fn take(&self) -> Vec<Message> {
        std::mem::take(&mut self.lock())
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, Vec<Message>> {
        // A panic elsewhere leaves whole messages behind; they stay worth reading.
        self.messages.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
    }
}
