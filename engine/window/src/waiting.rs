//! The window over files that have mistakes from the beginning: it lists them, and continues by itself when they are mended.

use std::time::{Duration, Instant};

use raxel_panels::Action;
use raxel_runtime::OpenError;
use raxel_terminal::console::To;
use raxel_terminal::failure::Result;
use raxel_terminal::session::open_failure;
use winit::event::{ElementState, WindowEvent};
use winit::event_loop::{ActiveEventLoop, ControlFlow};
use winit::keyboard::{Key, NamedKey};

use super::presenting::Open;
use super::problem_log::problems;
use super::{GROUND, Viewer};

/// Time between two drawings.
const LOOK: Duration = Duration::from_millis(50);

impl Viewer<'_> {
    /// The files to open have mistakes.
    pub(super) fn note_mistakes(&mut self, error: OpenError) -> Result {
        let OpenError::Project { diagnostics, texts } = error else {
            // No edit of the files helps.
            return Err(open_failure(error, self.console));
        };
        self.console.diagnostics(&diagnostics, &texts, To::Stderr);
        self.problems = problems(&diagnostics, &texts);
        Ok(())
    }

    /// Carries out requests while nothing runs.
    pub(super) fn waiting_event(&mut self, event_loop: &ActiveEventLoop, event: &WindowEvent) {
        if let Some(Open { window, overlay, .. }) = &mut self.window {
            overlay.take(window, event);
        }
        match event {
            WindowEvent::CloseRequested => event_loop.exit(),
            WindowEvent::Resized(size) => self.resize(*size),
            WindowEvent::KeyboardInput { event, .. }
                if event.state == ElementState::Pressed && event.logical_key == Key::Named(NamedKey::Escape) =>
            {
                event_loop.exit();
            }
            WindowEvent::RedrawRequested => {
                if let Err(failure) = self.draw(event_loop) {
                    self.stop(event_loop, failure);
                }
            }
            _ => {}
        }
    }

    /// Shows the mistakes, and carries out requests there.
    pub(super) fn draw_mistakes(&mut self, event_loop: &ActiveEventLoop) -> Result {
        event_loop.set_control_flow(ControlFlow::WaitUntil(Instant::now() + LOOK));
        self.look_at_log();
        let Some(Open { window, presenter, overlay, .. }) = &mut self.window else { return Ok(()) };
        let (panels, found) = (&mut self.panels, &self.problems);
        let actions = overlay.draw(window, |context| panels.waiting(context, "The files have mistakes", found));
        for action in actions {
            match action {
                Action::Copy(text) => overlay.copy(text),
                Action::Edit(place) => {
                    if let Err(why) = self.editors.open(self.session.project().root(), &place) {
                        self.console.message(&format!("warning: {why}"));
                    }
                }
                _ => {}
            }
        }
        overlay.present(presenter, |presenter, frame| presenter.present_blank(GROUND, Some(frame)))?;
        Ok(())
    }
}
