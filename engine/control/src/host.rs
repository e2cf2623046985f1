//! What runs a session beside the requests: a window, or nothing.

use std::ops::RangeInclusive;

use raxel_graph::checked::{Display, Value};
use raxel_runtime::Session;
use raxel_workbench::demo;
use raxel_workbench::kept::Kept;
use raxel_workbench::presets::Presets;
use raxel_workbench::recording::Recorder;
use raxel_workbench::writes::{Files, follow_files, set_again};

/// The writes that a session without a window can restore.
const MOST_WRITES: usize = 256;

/// How a window shows the kept picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum CompareMode {
    /// Not at all.
    Off,
    /// The shown picture left of an edge, the kept one right of it.
    Wipe,
    /// The shown picture minus the kept one.
    Difference,
}

/// Speeds of flight, in voxels a second.
pub const FLY_SPEEDS: RangeInclusive<f64> = 0.1..=100_000.0;

/// Most voxels across a brush, and most voxels of its height.
pub const LARGEST_BRUSH: u32 = 512;

/// The effect of a window's brush on voxels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Deserialize, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum BrushEffect {
    /// They become solid, in front of the face under the cursor.
    Add,
    /// They become air.
    Subtract,
    /// Solid ones get another material.
    Paint,
    /// The brush gets the material under the cursor.
    Pick,
}

/// The shape of a window's brush.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Deserialize, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum BrushShape {
    /// The voxel under the cursor.
    Voxel,
    /// A cube.
    Box,
    /// A ball.
    Sphere,
    /// A cylinder that stands on the face under the cursor.
    Cylinder,
}

/// The brush of a window's right mouse button.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Brush {
    /// Its effect.
    pub effect: BrushEffect,
    /// Its shape.
    pub shape: BrushShape,
    /// Voxels across, at most [`LARGEST_BRUSH`].
    pub size: u32,
    /// Voxels from base to top of a cylinder, at most [`LARGEST_BRUSH`].
    pub height: u32,
    /// Palette index; `None` for the material under the cursor.
    pub material: Option<u16>,
}

/// What became of the files of the last write.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Restored {
    /// Project paths of the restored files.
    pub files: Vec<String>,
    /// Why the others stay as they are, one line each.
    pub refused: Vec<String>,
}

/// The parts of a program that requests reach.
pub trait Host {
    /// The session.
    fn session(&mut self) -> &mut Session;

    /// The session, and the presets of its project.
    fn presets(&mut self) -> (&mut Session, &mut Presets);

    /// Files were written: they can be restored, and params follow them from the next reload on.
    fn wrote(&mut self, files: Files);

    /// Restores the files that were written last; none if no file was written.
    ///
    /// # Errors
    /// Why none was restored, in one line. The next call tries the same files.
    fn undo_write(&mut self) -> Result<Restored, String>;

    /// Whether a demo starts over at its end.
    fn set_looped(&mut self, looped: bool);

    /// That choice; without one, the demo decides.
    fn looped(&self) -> Option<bool>;

    /// Shows the shown target in another way than the graph's, or in the graph's again.
    fn set_display(&mut self, display: Option<Display>) {
        self.session().set_display(display);
    }

    /// The picture to compare with.
    fn kept(&self) -> Option<&Kept>;

    /// A picture will be kept. Gives the number of the request, for [`Self::keep`] or [`Self::give_up_kept`]; a picture that was asked for before is given up.
    fn awaits_kept(&mut self) -> u64 {
        0
    }

    /// Compares with another picture from now on. False if another one, or none, was asked for after this one: that counts.
    fn keep(&mut self, kept: Kept, number: u64) -> bool;

    /// The picture of this request does not come; the answer says why.
    fn give_up_kept(&mut self, _number: u64) {}

    /// Compares with none.
    fn forget(&mut self);

    /// Records params that are moved.
    fn recorder(&mut self) -> (&mut Session, &mut Recorder);

    /// The window, if there is one.
    fn window(&mut self) -> Option<&mut dyn InWindow> {
        None
    }
}

/// What only a window does.
pub trait InWindow {
    /// Shows the kept picture in another way. A choice that is `None` stays as it is.
    fn compare(&mut self, mode: Option<CompareMode>, gain: Option<f32>, flipped: Option<bool>);

    /// Gives up the pass that the device has worked on for long. Returns its name if that is known; `None` if the device does not work for long.
    fn cancel(&mut self) -> Option<Option<String>>;

    /// Most frames a second; `None` is no bound.
    fn fps_cap(&self) -> Option<u32>;

    /// Bounds the frames a second, or no more.
    fn set_fps_cap(&mut self, cap: Option<u32>);

    /// Voxels that keys fly in a second.
    fn fly_speed(&self) -> f64;

    /// Sets the voxels that keys fly in a second, within [`FLY_SPEEDS`].
    fn set_fly_speed(&mut self, voxels: f64);

    /// The brush of the right mouse button.
    fn brush(&self) -> Brush;

    /// Gives the right mouse button another brush.
    fn set_brush(&mut self, brush: Brush);
}

/// A session without a window.
pub(super) struct Alone<'s> {
    session: &'s mut Session,
    presets: Presets,
    /// Files that were written, oldest first.
    writes: Vec<Files>,
    /// Params and values that were written to a file that was not read again yet.
    following: Vec<(String, Value)>,
    kept: Option<Kept>,
    /// Whether the demo starts over, if a request has said so.
    looped: Option<bool>,
    recorder: Recorder,
}

impl<'s> Alone<'s> {
    pub(crate) fn new(session: &'s mut Session) -> Self {
        let presets = Presets::of(session.project().root());
        let recorder = Recorder::default();
        Self { session, presets, writes: Vec::new(), following: Vec::new(), kept: None, looped: None, recorder }
    }

    /// An edit runs, or other files were opened: params whose values the edit has follow their files.
    pub(crate) fn reloaded(&mut self, opened: bool) {
        if opened {
            self.looped = None;
            self.following.clear();
            self.recorder.forget();
        }
        follow_files(self.session, &mut self.following);
    }
}

impl Host for Alone<'_> {
    fn session(&mut self) -> &mut Session {
        self.session
    }

    fn presets(&mut self) -> (&mut Session, &mut Presets) {
        (self.session, &mut self.presets)
    }

    fn wrote(&mut self, files: Files) {
        self.following.extend(files.params.iter().cloned());
        if files.written.is_empty() {
            return;
        }
        self.writes.push(files);
        if self.writes.len() > MOST_WRITES {
            self.writes.remove(0);
        }
    }

    fn undo_write(&mut self) -> Result<Restored, String> {
        let Some(Files { written, params }) = self.writes.pop() else { return Ok(Restored::default()) };
        let mut restored = Restored::default();
        for written in written.iter().rev() {
            match written.undo() {
                Ok(_) => restored.files.push(written.file.clone()),
                Err(error) => restored.refused.push(error),
            }
        }
        if restored.files.is_empty() {
            self.writes.push(Files { written, params });
            return Err(restored.refused.join("; "));
        }
        demo::leave_if_gone(self.session);
        set_again(self.session, &mut self.following, &params);
        Ok(restored)
    }

    fn set_looped(&mut self, looped: bool) {
        self.looped = Some(looped);
    }

    fn looped(&self) -> Option<bool> {
        self.looped
    }

    fn kept(&self) -> Option<&Kept> {
        self.kept.as_ref()
    }

    fn keep(&mut self, kept: Kept, _: u64) -> bool {
        self.kept = Some(kept);
        true
    }

    fn forget(&mut self) {
        self.kept = None;
    }

    fn recorder(&mut self) -> (&mut Session, &mut Recorder) {
        (self.session, &mut self.recorder)
    }
}
