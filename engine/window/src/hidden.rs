//! A window that nobody sees: it is minimised, or the window system holds its redraws back. A program that drives it has its answers and its frames
//! all the same.

use std::cell::Cell;
use std::time::{Duration, Instant};

use winit::event_loop::{ActiveEventLoop, ControlFlow};

use super::{STILL, Viewer};

/// A window system that holds a redraw back for so long does not show the window.
const HELD_BACK: Duration = Duration::from_millis(250);

/// The redraws that were asked for.
#[derive(Debug, Default)]
pub(super) struct Redraws {
    /// Since when one is on its way.
    asked: Cell<Option<Instant>>,
}

impl Redraws {
    /// One is asked for.
    pub(crate) fn ask(&self, now: Instant) {
        self.asked.set(self.asked.get().or(Some(now)));
    }

    /// One has come.
    pub(crate) fn came(&self) {
        self.asked.set(None);
    }

    /// Whether one does not come.
    pub(crate) fn are_held_back(&self, now: Instant) -> bool {
        self.asked.get().is_some_and(|asked| now.duration_since(asked) >= HELD_BACK)
    }
}

impl Viewer<'_> {
    /// Whether nobody sees the window.
    pub(super) fn is_hidden(&self) -> bool {
        // While its surface is lost, the presenter has no extent either. A window that counted as hidden then would never get another surface.
        let has_area = self.window.as_ref().is_some_and(|open| {
            open.presenter.extent().is_some() || {
                let size = open.window.inner_size();
                size.width > 0 && size.height > 0
            }
        });
        !has_area || self.redraws.are_held_back(Instant::now())
    }

    /// Goes on for a program without the redraws that do not come. Without a program, nothing happens until the window is shown again.
    pub(super) fn go_on_hidden(&mut self, event_loop: &ActiveEventLoop) {
        if self.control.is_none() {
            event_loop.set_control_flow(ControlFlow::Wait);
            return;
        }
        if let Err(failure) = self.draw(event_loop) {
            self.stop(event_loop, failure);
        }
        event_loop.set_control_flow(ControlFlow::WaitUntil(Instant::now() + STILL));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_redraw_that_does_not_come_is_held_back() {
        let (redraws, start) = (Redraws::default(), Instant::now());
        let held_back = |milliseconds| redraws.are_held_back(start + Duration::from_millis(milliseconds));
        assert!(!held_back(1000), "none was asked for");
        redraws.ask(start);
        redraws.ask(start + Duration::from_millis(200));
        assert!(!held_back(249) && held_back(250), "the first one counts");
        redraws.came();
        assert!(!held_back(1000));
    }
}
