//! The window as a program reaches it: what requests do here as its panels do.

use raxel_control::{Brush, BrushEffect, BrushShape, CompareMode, Host, InWindow, LARGEST_BRUSH, Next, Restored};
use raxel_graph::checked::Display;
use raxel_panels::view::{self, Busy, Map};
use raxel_runtime::Session;
use raxel_terminal::session::frame_failure;
use raxel_workbench::kept::Kept;
use raxel_workbench::presets::Presets;
use raxel_workbench::recording::Recorder;
use raxel_workbench::writes;

use super::Viewer;
use super::comparing::Coming;
use super::history::Files;

const _: () = assert!(LARGEST_BRUSH == view::Brush::LARGEST);

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

    fn awaits_kept(&mut self) -> u64 {
        let (number, said) = self.comparing.ask("the program's picture", Coming::Asker);
        said.into_iter().for_each(|said| self.notice(said));
        number
    }

    fn keep(&mut self, kept: Kept, number: u64) -> bool {
        self.touched = true;
        self.comparing.keep(kept, number)
    }

    fn give_up_kept(&mut self, number: u64) {
        // The program gets the reason.
        let _ = self.comparing.give_up_number(number, "it does not come");
    }

    fn forget(&mut self) {
        self.touched = true;
        let said = self.comparing.forget();
        said.into_iter().for_each(|said| self.notice(said));
    }

    fn recorder(&mut self) -> (&mut Session, &mut Recorder) {
        (&mut self.session, &mut self.recorder)
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

    fn fps_cap(&self) -> Option<u32> {
        self.fps_cap
    }

    fn set_fps_cap(&mut self, cap: Option<u32>) {
        (self.fps_cap, self.touched) = (cap, true);
    }

    fn fly_speed(&self) -> f64 {
        self.controls.speed()
    }

    fn set_fly_speed(&mut self, voxels: f64) {
        self.controls.set_speed(voxels);
        self.touched = true;
    }

    fn brush(&self) -> Brush {
        let view::Brush { shape, effect, size, height, material } = self.brush;
        let effect = match effect {
            view::Effect::Add => BrushEffect::Add,
            view::Effect::Subtract => BrushEffect::Subtract,
            view::Effect::Paint => BrushEffect::Paint,
            view::Effect::Pick => BrushEffect::Pick,
        };
        let shape = match shape {
            view::Shape::Voxel => BrushShape::Voxel,
            view::Shape::Box => BrushShape::Box,
            view::Shape::Sphere => BrushShape::Sphere,
            view::Shape::Cylinder => BrushShape::Cylinder,
        };
        Brush { effect, shape, size, height, material }
    }

    fn set_brush(&mut self, brush: Brush) {
        let Brush { effect, shape, size, height, material } = brush;
        let effect = match effect {
            BrushEffect::Add => view::Effect::Add,
            BrushEffect::Subtract => view::Effect::Subtract,
            BrushEffect::Paint => view::Effect::Paint,
            BrushEffect::Pick => view::Effect::Pick,
        };
        let shape = match shape {
            BrushShape::Voxel => view::Shape::Voxel,
            BrushShape::Box => view::Shape::Box,
            BrushShape::Sphere => view::Shape::Sphere,
            BrushShape::Cylinder => view::Shape::Cylinder,
        };
        self.brush = view::Brush { shape, effect, size, height, material };
        self.touched = true;
    }
}
