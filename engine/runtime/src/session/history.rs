//! Whether the contents of earlier frames are there: `history.valid`.

use raxel_execute::Histories;

/// Counts the frames since a history was cleared.
#[derive(Default)]
pub(super) struct History {
    /// Frames that have run since.
    frames: u32,
    /// The length of the longest history, in frames.
    depth: u32,
    /// The targets and buffers whose clearing by another size was reported.
    said: Vec<String>,
}

impl History {
    /// Another frame begins: how far back the running histories go, and whether one of them is cleared first.
    pub(crate) fn begin(&mut self, known: Histories) {
        self.depth = known.depth;
        if known.cleared {
            self.frames = 0;
        }
    }

    /// The frame has run.
    pub(crate) fn end(&mut self) {
        self.frames = self.frames.saturating_add(1);
    }

    /// Resources that are carried from frame to frame start over.
    pub(crate) fn reset(&mut self) {
        self.frames = 0;
    }

    /// Whether every history holds contents of frames; never in the first frame.
    pub(crate) fn is_valid(&self) -> bool {
        self.frames >= self.depth.max(1)
    }

    /// Whether these were cleared by another size for the first time: a window that is being dragged has many sizes.
    pub(crate) fn is_news(&mut self, cleared: &[String]) -> bool {
        let new: Vec<String> = cleared.iter().filter(|name| !self.said.contains(name)).cloned().collect();
        let any = !new.is_empty();
        self.said.extend(new);
        any
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_history_is_valid_once_it_is_full() {
        let mut history = History::default();
        let mut frame = |depth, cleared| {
            history.begin(Histories { depth, cleared });
            let valid = history.is_valid();
            history.end();
            valid
        };
        // Two frames back: the third frame is the first that finds both.
        assert_eq!([frame(2, true), frame(2, false), frame(2, false)], [false, false, true]);
        assert_eq!([frame(1, true), frame(1, false)], [false, true]);
        // Without any history only the first frame has none before it.
        let mut history = History::default();
        history.begin(Histories::default());
        assert!(!history.is_valid());
        history.end();
        assert!(history.is_valid());
        history.reset();
        assert!(!history.is_valid());
    }

    #[test]
    fn a_dragged_window_says_it_once() {
        let mut history = History::default();
        let names = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect::<Vec<_>>();
        assert!(!history.is_news(&[]));
        assert!(history.is_news(&names(&["sum"])));
        assert!(!history.is_news(&names(&["sum"])));
        assert!(history.is_news(&names(&["sum", "light"])));
    }
}
