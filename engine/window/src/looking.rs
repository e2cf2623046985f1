//! Zoom and comparison, from keys, mouse and panels.

use raxel_panels::view::{CompareMode, Magnified, Shown};
use raxel_panels::{Action, Panel};
use raxel_runtime::debug_target::DebugTarget;
use raxel_workbench::kept::Kept;
use winit::keyboard::ModifiersState;

use super::inspector::{CopiedFor, Copy};
use super::magnifier::Extents;
use super::{Viewer, panel_data};

/// Pixels of a texel from which on its values are written on it.
const WRITTEN: f64 = 32.0;

/// How much one line of the wheel magnifies.
const WHEEL: f64 = 1.25;

/// The part of the window that an arrow key moves the picture by.
const STEP: f64 = 0.125;

/// One step of zoom or pan by a key.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Move {
    /// Twice as large, about the cursor.
    In,
    /// Half as large.
    Out,
    /// The whole picture.
    Whole,
    /// To the neighbour on the left, on the right, above or below.
    Step { right: i8, down: i8 },
}

impl Viewer<'_> {
    /// Whether the wheel magnifies, rather than setting the camera's speed.
    pub(super) fn wheel_magnifies(&self) -> bool {
        self.modifiers.contains(ModifiersState::CONTROL)
            || self.magnifier.is_on()
            || self.panels.layout.is_open(Panel::Inspect)
    }

    /// Magnifies about the cursor by `lines` lines of the wheel.
    pub(super) fn magnify(&mut self, lines: f64) {
        self.zoom(WHEEL.powf(lines.clamp(-20.0, 20.0)));
    }

    /// A key of zoom or pan.
    pub(super) fn look(&mut self, step: Move) {
        match step {
            Move::In => self.zoom(2.0),
            Move::Out => self.zoom(0.5),
            Move::Whole => {
                self.magnifier.reset();
                self.notice("shows the whole picture".to_owned());
            }
            Move::Step { right, down } => {
                self.touched = true;
                self.magnifier.pan([right, down].map(|steps| -STEP * f64::from(steps)));
            }
        }
    }

    fn zoom(&mut self, factor: f64) {
        let window = self.session.viewport().window();
        let middle = window.map(|side| f64::from(side) / 2.0);
        let at = self.controls.on_picture().unwrap_or(middle);
        let at = [0, 1].map(|axis| (at[axis] / f64::from(window[axis])).clamp(0.0, 1.0));
        self.magnifier.zoom_about(at, factor, self.extents());
        let whole = if self.magnifier.is_on() { "; 0 shows the whole" } else { "" };
        self.notice(format!("magnified {:.1} times{whole}", self.magnifier.zoom()));
    }

    /// Extents of the shown target in texels, and of the window in pixels. A buffer has as many texels as the output has pixels.
    fn extents(&self) -> Extents {
        Extents {
            picture: self.shown_extent().unwrap_or(self.session.size()),
            window: self.session.viewport().window(),
        }
    }

    /// Extent of the shown mip of a target.
    fn shown_extent(&self) -> Option<[u32; 2]> {
        let shown = self.shown();
        let resource = self.session.graph().find_resource(&shown.resource)?;
        let [width, height, _] = self.session.plan()?.sizes.get(resource.0 as usize)?.texels(shown.mip)?;
        Some([width, height])
    }

    fn shown(&self) -> Shown {
        panel_data::shown(self.session.debug_target(), self.session.graph())
    }

    /// Brings the pinned texel into sight.
    pub(super) fn reveal_pin(&mut self) {
        if let Some(pin) = self.inspector.pinned() {
            let extents = Extents { picture: pin.extent, window: self.session.viewport().window() };
            self.magnifier.reveal(pin.texel, extents);
        }
    }

    /// Whether texels are large enough for their values to be written on them.
    pub(super) fn writes_values(&self) -> bool {
        let Extents { picture, window } = self.extents();
        let texel = |axis: usize| f64::from(window[axis]) / f64::from(picture[axis]) * self.magnifier.zoom();
        self.magnifier.is_on() && texel(0).min(texel(1)) >= WRITTEN && self.panels.layout.visible
    }

    /// The drawings of the panels over a magnified picture.
    pub(super) fn magnified(&self) -> Magnified {
        let region = self.magnifier.region();
        let values = if self.writes_values() { self.inspector.written(&self.shown(), &region) } else { Vec::new() };
        Magnified { origin: region.origin, size: region.size, extent: self.shown_extent().unwrap_or([0; 2]), values }
    }

    /// Something that a panel or a key asks of the comparison.
    pub(super) fn compare(&mut self, action: Action) {
        self.touched = true;
        match action {
            Action::Keep => self.inspector.copy(CopiedFor::Keeping),
            Action::KeepLive => {
                let target = DebugTarget { after: None, ..self.session.debug_target().clone() };
                let named = if target.resource.is_empty() { DebugTarget::resource(self.target()) } else { target };
                self.notice(format!("compares with {named} as it goes on: show another target; X goes through ways"));
                self.comparing.keep(Kept::live(named));
            }
            Action::KeepFile(path) => self.comparing.load(&self.session.project().root().join(&path), &path),
            Action::ForgetKept => self.comparing.forget(),
            Action::CompareMode(mode) => self.comparing.set_mode(mode),
            Action::Flip if self.comparing.is_on() => self.comparing.flip(),
            Action::Gain(gain) => self.comparing.set_gain(gain),
            Action::Measure => {
                self.comparing.await_figures();
                let shown = self.shown();
                let (name, shown) = (self.name_of_copy(&shown), panel_data::debug_target(&shown));
                if !self.comparing.measure_live(&mut self.session, &name, &shown) {
                    self.inspector.copy(CopiedFor::Measuring);
                }
            }
            _ => self.notice("B keeps the shown picture, to compare with it".to_owned()),
        }
    }

    /// Goes on to the next way of comparing.
    pub(super) fn next_comparison(&mut self) {
        if !self.comparing.is_on() {
            return self.notice("B keeps the shown picture, to compare with it".to_owned());
        }
        let said = match self.comparing.next_mode() {
            CompareMode::Off => "the kept picture is not shown",
            CompareMode::Wipe => "left of the edge the shown picture, right of it the kept one",
            CompareMode::Difference => "shown minus kept",
        };
        self.notice(said.to_owned());
    }

    fn name_of_copy(&self, shown: &Shown) -> String {
        format!("{}, generation {}", panel_data::debug_target(shown), self.reloads.shown)
    }

    /// After a frame: takes a copy that was asked for.
    pub(super) fn take_copy(&mut self) {
        let Some(Copy { purpose, shown, texels }) = self.inspector.copied(self.session.graph()) else { return };
        let Some((texels, display)) = texels else {
            self.comparing.give_up_figures();
            return self.notice(format!("`{}` is a buffer: only pictures of targets are compared", shown.resource));
        };
        let name = self.name_of_copy(&shown);
        match purpose {
            CopiedFor::Keeping => {
                self.comparing.keep(Kept::copy(&name, texels));
                self.notice(format!("kept {name}; X goes through ways of comparing, V shows it alone"));
            }
            CopiedFor::Measuring => self.comparing.measure(&name, texels, display),
        }
    }
}
