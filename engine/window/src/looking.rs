//! Zoom and comparison, from keys, mouse and panels.

use raxel_execute::{Captured, ReadTicket, Texels};
use raxel_graph::checked::ResourceKind;
use raxel_panels::view::{CompareMode, Magnified, Shown};
use raxel_panels::{Action, Panel};
use raxel_runtime::debug_target::DebugTarget;
use raxel_workbench::kept::Kept;
use winit::keyboard::ModifiersState;

use super::comparing::{Coming, kept_message};
use super::inspector::{Copied, CopiedFor};
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
            Action::Keep => self.keep_shown(),
            Action::KeepLive => {
                let target = DebugTarget { after: None, ..self.session.debug_target().clone() };
                let named = if target.resource.is_empty() { DebugTarget::resource(self.target()) } else { target };
                self.notice(format!("compares with {named} as it goes on: show another target; X goes through ways"));
                let (number, said) = self.comparing.ask(&named.to_string(), Coming::Asker);
                said.into_iter().for_each(|said| self.notice(said));
                self.comparing.keep(Kept::live(named), number);
            }
            Action::KeepFile(path) => {
                let said = self.comparing.load(&self.session.project().root().join(&path), &path);
                said.into_iter().for_each(|said| self.notice(said));
            }
            Action::ForgetKept => {
                let said = self.comparing.forget();
                said.into_iter().for_each(|said| self.notice(said));
            }
            Action::CompareMode(mode) => self.comparing.set_mode(mode),
            Action::Flip if self.comparing.is_on() => self.comparing.flip(),
            Action::Gain(gain) => self.comparing.set_gain(gain),
            Action::Measure => {
                self.comparing.await_figures();
                let shown = self.shown();
                let (name, shown) = (name_of_copy(&shown, self.reloads.shown), panel_data::debug_target(&shown));
                if !self.comparing.measure_live(&mut self.session, &name, &shown) {
                    self.measure_shown(&name);
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

    /// Keeps what is shown now, whatever is shown when the copy of it is there.
    fn keep_shown(&mut self) {
        let shown = self.shown();
        if self.is_buffer(&shown) {
            return self.notice(no_picture(&shown));
        }
        let name = name_of_copy(&shown, self.reloads.shown);
        let ticket = self.request_shown(&shown);
        let in_frame = ticket.is_none();
        let (number, said) = self.comparing.ask(&name, ticket.map_or(Coming::Asker, Coming::Copy));
        if in_frame {
            self.inspector.copy(CopiedFor::Keeping(number), shown);
        }
        said.into_iter().for_each(|said| self.notice(said));
    }

    /// Measures what is shown now against the kept picture.
    fn measure_shown(&mut self, name: &str) {
        let shown = self.shown();
        if self.is_buffer(&shown) {
            return self.comparing.give_up_figures("a buffer is shown");
        }
        match self.request_shown(&shown) {
            Some(ticket) => {
                let display = self.inspector.display_of(self.session.graph(), &shown);
                self.comparing.measure_copy(name, ticket, display);
            }
            None => self.inspector.copy(CopiedFor::Measuring, shown),
        }
    }

    fn is_buffer(&self, shown: &Shown) -> bool {
        let graph = self.session.graph();
        let found = graph.find_resource(&shown.resource).map(|id| &graph.resource(id).kind);
        matches!(found, Some(ResourceKind::Buffer(_)))
    }

    /// A copy of a target as the last frame left it. `None` if the next frame has to make it: within a frame, or of a target that did not run yet.
    fn request_shown(&mut self, shown: &Shown) -> Option<ReadTicket<Texels>> {
        let Shown { resource, age, mip, layer, after } = shown;
        if after.is_some() {
            return None;
        }
        self.session.request_texels(resource, *age, *mip, *layer).ok()
    }

    /// After a frame: takes the copies that it was asked for.
    pub(super) fn take_copies(&mut self) {
        for Copied { purpose, taken: copy, generation, elements } in self.inspector.copied() {
            let name = name_of_copy(&copy.shown, generation);
            let texels = match &*copy.captured {
                Captured::Texels(texels) => Some(texels.clone()),
                Captured::Bytes { .. } => None,
            };
            match (purpose, texels) {
                (CopiedFor::Table, _) => self.write_copied(&copy.shown, elements, copy.captured),
                (CopiedFor::Keeping(number), Some(texels)) => {
                    let kept = Kept::copy(&name, texels);
                    let said = kept_message(&kept.name);
                    if self.comparing.keep(kept, number) {
                        self.notice(said);
                    }
                }
                (CopiedFor::Measuring, Some(texels)) => {
                    let display = self.inspector.display_of(self.session.graph(), &copy.shown);
                    self.comparing.measure(&name, texels, display);
                }
                (CopiedFor::Keeping(number), None) => {
                    let said = self.comparing.give_up_number(number, "a buffer is shown");
                    self.notice(said.unwrap_or_else(|| no_picture(&copy.shown)));
                }
                (CopiedFor::Measuring, None) => {
                    self.comparing.give_up_figures("a buffer is shown");
                    self.notice(no_picture(&copy.shown));
                }
            }
        }
        for (purpose, shown) in self.inspector.given_up() {
            let why = "another resource was shown before a frame could copy it";
            let said = match purpose {
                CopiedFor::Keeping(number) => self.comparing.give_up_number(number, why),
                CopiedFor::Measuring => {
                    self.comparing.give_up_figures(why);
                    None
                }
                CopiedFor::Table => Some(format!("{}.csv is not written: {why}", shown.resource)),
            };
            said.into_iter().for_each(|said| self.warn(said));
        }
    }
}

fn name_of_copy(shown: &Shown, generation: u64) -> String {
    format!("{}, generation {generation}", panel_data::debug_target(shown))
}

fn no_picture(shown: &Shown) -> String {
    format!("`{}` is a buffer: only pictures of targets are compared", shown.resource)
}
