//! The window as a program reaches it: what requests do here as its panels do.

use raxel_control::{CompareMode, Host, InWindow, Next, Restored};
use raxel_graph::checked::Display;
use raxel_panels::view::{self, Busy, Map};
use raxel_runtime::Session;
use raxel_terminal::session::frame_failure;
use raxel_workbench::kept::Kept;
use raxel_workbench::presets::Presets;
use raxel_workbench::writes;

use super::Viewer;
use super::history::Files;

impl Viewer<'_> {
    /// Answers the requests that have come.
    pub(super) fn answer_requests(&mut self) -> Next {
        let Some(mut control) = self.control.take() else { return Next::More };
        let next = control.poll(self);
        if let Some(complaint) = control.complaint() {
            self.console.message(complaint);
        }
        self.control = Some(control);
        next
    }
}

impl Host for Viewer<'_> {
    fn session(&mut self) -> &mut Session {
        &mut self.session
    }

    fn presets(&mut self) -> (&mut Session, &mut Presets) {
        (&mut self.session, &mut self.presets)
    }

    fn wrote(&mut self, files: writes::Files) {
        let writes::Files { written, params } = files;
        self.written.extend(params.iter().cloned());
        self.note_files(Files { written, params });
        self.touched = true;
    }

    fn undo_write(&mut self) -> Result<Restored, String> {
        Viewer::undo_write(self)
    }

    fn set_looped(&mut self, looped: bool) {
        self.looped = Some(looped);
    }

    fn looped(&self) -> Option<bool> {
        self.looped
    }

    fn set_display(&mut self, display: Option<Display>) {
        let map = |Display { map, range, channel }| Map { map: map as usize, range: Some(range), channel };
        self.inspector.shows(display.map(map));
        // At once: a program may read the picture before the next frame.
        self.session.set_display(display);
        self.touched = true;
    }

    fn kept(&self) -> Option<&Kept> {
        self.comparing.kept()
    }

    fn keep(&mut self, kept: Option<Kept>) {
        match kept {
            Some(kept) => self.comparing.keep(kept),
            None => self.comparing.forget(),
        }
        self.touched = true;
    }

    fn window(&mut self) -> Option<&mut dyn InWindow> {
        Some(self)
    }
}

impl InWindow for Viewer<'_> {
    fn compare(&mut self, mode: Option<CompareMode>, gain: Option<f32>, flipped: Option<bool>) {
        if let Some(mode) = mode {
            self.comparing.set_mode(match mode {
                CompareMode::Off => view::CompareMode::Off,
                CompareMode::Wipe => view::CompareMode::Wipe,
                CompareMode::Difference => view::CompareMode::Difference,
            });
        }
        if let Some(gain) = gain {
            self.comparing.set_gain(gain);
        }
        if let Some(flipped) = flipped {
            self.comparing.set_flipped(flipped);
        }
        self.touched = true;
    }

    fn cancel(&mut self) -> Option<Option<String>> {
        let Busy { pass, .. } = self.busy.take()?;
        if let Err(error) = self.session.cancel() {
            // The next turn of the event loop ends the window with it.
            let failure = frame_failure(error, self.console);
            self.failure.get_or_insert(failure);
        }
        Some(pass)
    }
}
