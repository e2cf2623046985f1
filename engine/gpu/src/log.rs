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

impl Message {
    /// Whether the layer is mistaken. A shader may ask for the length of a buffer and access nothing in it. Release 1.4.309 counts that as an
    /// access of no kind, and demands protection from changes of layout. Buffers have no layout.
    fn is_mistaken(&self) -> bool {
        self.id.starts_with("SYNC-HAZARD-")
            && self.text.contains("writes to VkBuffer")
            && self.text.ends_with("it must protect layout transition accesses.")
    }
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
        if message.is_mistaken() {
            return;
        }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_buffer_needs_no_protection_from_changes_of_layout() {
        let log = ValidationLog::default();
        let hazard = |what: &str, must: &str| Message {
            severity: Severity::Error,
            id: "SYNC-HAZARD-WRITE-AFTER-WRITE".to_owned(),
            text: format!(
                "vkCmdDispatch(): WRITE_AFTER_WRITE hazard detected. Shader stage VK_SHADER_STAGE_COMPUTE_BIT writes to {what}, which was previously \
                 written by vkCmdDispatchIndirect[collect]. \nThe current synchronization allows VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT accesses at \
                 VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT, but to prevent this hazard, it must {must}."
            ),
        };
        log.push(hazard("VkBuffer 0xd1d0000000d1d[items]", "protect layout transition accesses"));
        assert_eq!(log.take(), []);
        // An image has a layout, and an access has a kind.
        let right = [
            hazard("VkImage 0xd1d0000000d1d[color]", "protect layout transition accesses"),
            hazard(
                "VkBuffer 0xd1d0000000d1d[items]",
                "allow VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT accesses at the same stage",
            ),
        ];
        right.iter().for_each(|message| log.push(message.clone()));
        assert_eq!(log.take(), right);
    }
}
