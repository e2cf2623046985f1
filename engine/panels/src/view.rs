//! The contents of the panels, as plain data. The window fills it for each frame that it draws.

mod comparing;
mod demo;
mod editing;
mod magnified;

use std::sync::Arc;

use raxel_picture::{NotFinite, Sought, Statistics};

use crate::samples::Samples;

pub use comparing::{Compare, CompareMode, Figures};
pub use demo::{Lane, Timeline, Track};
pub use editing::{Brush, Editing, Effect, Shape, Swatch};
pub use magnified::{Magnified, WrittenTexel};

/// Everything that the panels show.
#[derive(Clone, Debug, Default)]
pub struct View<'a> {
    /// The shown target and the problems.
    pub status: Status,
    /// Times, memory, scale.
    pub frame: Frame<'a>,
    /// Passes in the order in which they run, those that do not run in their place.
    pub passes: Vec<Pass<'a>>,
    /// Targets and buffers in the order of the file.
    pub resources: &'a [Resource],
    /// Small pictures of targets, while the graph is drawn as a picture.
    pub thumbnails: Vec<Thumbnail>,
    /// Live values in the order of the file.
    pub params: Vec<Param>,
    /// Moved params become keys of the demo.
    pub records: bool,
    /// Named values of them, by name.
    pub presets: Vec<Preset>,
    /// Diagnostics.
    pub problems: &'a [Problem],
    /// The shaders check the bounds of their accesses.
    pub checks_bounds: bool,
    /// World and camera.
    pub world: World<'a>,
    /// The demo, if one runs.
    pub timeline: Option<Timeline>,
    /// The contents of the shown resource.
    pub inspected: Option<&'a Inspected>,
    /// The part of the picture that fills the window.
    pub magnified: Magnified,
    /// The comparison of the picture.
    pub compare: Compare,
    /// Files of the project that can be opened, as they were listed last: by kind, and each kind in order of path.
    pub files: Option<&'a [ProjectFile]>,
}

/// The shown target, and its state.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Status {
    /// Name of the graph.
    pub graph: String,
    /// The shown target; its resource is never empty.
    pub shown: Shown,
    /// The same while the pointer rests on no pass.
    pub locked: Shown,
    /// Whether what is shown is what the graph presents by itself.
    pub is_default: bool,
    /// The clock stands still.
    pub paused: bool,
    /// Seconds of the take that is recorded.
    pub recording: Option<u64>,
    /// Generation that runs.
    pub generation: u64,
    /// A newer generation that is wrong.
    pub failed: Option<u64>,
    /// There is no plan for the wanted size or debug target.
    pub refused: bool,
    /// The device has worked for long.
    pub busy: Option<Busy>,
    /// The driver has worked on a pipeline for long.
    pub compiling: Option<Compiling>,
    /// Something that was just done, or could not be done.
    pub notice: Option<String>,
    /// Whether there is a picture yet.
    pub picture: FirstPicture,
    /// Project path of the graph's file.
    pub graph_file: String,
    /// Project paths of the files that the window wrote last, as long as that can be undone.
    pub written: Vec<String>,
}

/// The kinds of files of a project.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[allow(missing_docs, reason = "each is the kind of its name")]
pub enum FileKind {
    Demo,
    World,
    Graph,
}

/// A file of the project that can be opened.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ProjectFile {
    /// Its kind.
    pub kind: FileKind,
    /// Its project path.
    pub path: String,
    /// It runs.
    pub runs: bool,
}

/// A device that has worked for long.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Busy {
    /// The pass that it works on, if that is known.
    pub pass: Option<String>,
    /// Since how many seconds.
    pub seconds: u64,
}

/// A pipeline that the driver compiles.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Compiling {
    /// The pass that it is for.
    pub pass: String,
    /// Since how many seconds.
    pub seconds: u64,
    /// Pipelines that are not there yet, this one included.
    pub left: usize,
}

/// How far a window that was opened has come.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FirstPicture {
    /// There was none yet.
    Awaited,
    /// There was one.
    #[default]
    Shown,
}

/// A resource at a point of the frame.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Shown {
    /// Its name.
    pub resource: String,
    /// Frames ago.
    pub age: u32,
    /// Mip.
    pub mip: u32,
    /// Layer, or slice of a 3-D target.
    pub layer: u32,
    /// Right after this pass; at the end of the frame when `None`.
    pub after: Option<String>,
}

impl Shown {
    /// A resource right after a pass.
    pub fn after(resource: impl Into<String>, pass: Option<String>) -> Self {
        Self { resource: resource.into(), after: pass, ..Self::default() }
    }

    /// The part of it that a pass touches.
    #[must_use]
    pub fn part(self, used: Use) -> Self {
        Self { mip: used.mip, layer: used.layer, ..self }
    }

    /// Whether it is the same resource at the same point; another mip or layer may be seen.
    pub(crate) fn is_at(&self, point: &Self) -> bool {
        Self { mip: point.mip, layer: point.layer, ..self.clone() } == *point
    }
}

/// Times of frames, memory, and what can be set of them.
#[derive(Clone, Debug, Default)]
pub struct Frame<'a> {
    /// Milliseconds from frame to frame.
    pub interval: Option<&'a Samples>,
    /// Milliseconds of the host from the begin of a frame to its submission.
    pub cpu: Option<&'a Samples>,
    /// Milliseconds of the device from the begin of the first pass to the end of the last.
    pub gpu: Option<&'a Samples>,
    /// Bytes of targets and buffers.
    pub memory: u64,
    /// Bytes that transient resources save by sharing memory.
    pub saved: u64,
    /// Pixels of the output for each pixel of the window, along each axis.
    pub scale: f64,
    /// Smallest and largest scale.
    pub scales: [f64; 2],
    /// Extent of the output in pixels.
    pub output: [u32; 2],
    /// Most frames a second.
    pub fps_cap: Option<u32>,
    /// Name of the device.
    pub device: String,
    /// Dispatches of the last frame, passes it skipped since their results are still valid, and passes that were not due or are off.
    pub ran: [u32; 3],
    /// The world in numbers.
    pub world: WorldStatistics,
}

/// A world in numbers.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct WorldStatistics {
    /// Its extent.
    pub extent: WorldExtent,
    /// The sources that passes read of it: names, and bytes on the device.
    pub sources: Vec<(String, u64)>,
    /// Edits that can be undone, and redone.
    pub edits: [usize; 2],
}

/// The extent of a world.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WorldExtent {
    /// All of it, always.
    Whole {
        /// Chunks of 64³ voxels that hold something.
        chunks: usize,
        /// Solid voxels.
        voxels: u64,
        /// Those of them that give off light.
        lamps: u64,
    },
    /// The part that is loaded around the camera.
    Around(Loading),
}

impl Default for WorldExtent {
    fn default() -> Self {
        Self::Whole { chunks: 0, voxels: 0, lamps: 0 }
    }
}

/// The progress of loading a world.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Loading {
    /// Chunks that are there, and that are wanted.
    pub there: [usize; 2],
    /// Bytes on the device, and bytes that there are.
    pub device: [u64; 2],
    /// Bytes of packed chunks on the host, and bytes that they may take.
    pub host: [u64; 2],
    /// Chunks that were found on the host, and chunks that were made.
    pub found_made: [u64; 2],
    /// States of the world that frames were given.
    pub publications: u64,
    /// Lamps that are listed.
    pub lamps: u64,
}

/// The state of a pass in the last frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PassState {
    /// It was dispatched.
    Ran,
    /// Its results are still valid.
    Skipped,
    /// It is not due in each frame.
    NotDue,
    /// It is switched off since the device was lost while it ran.
    Off,
    /// Nothing that is shown depends on it.
    Unused,
    /// Its `when` does not hold.
    Condition,
}

impl PassState {
    /// A word for a row.
    pub fn word(self) -> &'static str {
        match self {
            PassState::Ran => "",
            PassState::Skipped => "unchanged",
            PassState::NotDue => "not due",
            PassState::Off => "off",
            PassState::Unused => "unused",
            PassState::Condition => "when: no",
        }
    }

    /// The reason in a sentence.
    pub fn reason(self) -> &'static str {
        match self {
            PassState::Ran => "The pass ran in the last frame.",
            PassState::Skipped => "Skipped: none of its inputs has changed, so its results are still valid.",
            PassState::NotDue => "Not due in the last frame: `every` of the pass says when it runs.",
            PassState::Off => {
                "Switched off: the device was lost while the pass ran. A change of its shader, or of its part of the graph, switches it on."
            }
            PassState::Unused => "Culled: nothing that is shown depends on its outputs.",
            PassState::Condition => "Left out: its `when` does not hold.",
        }
    }

    /// Whether it has a place in the frame.
    pub fn is_planned(self) -> bool {
        !matches!(self, PassState::Unused | PassState::Condition)
    }
}

/// A pass.
#[derive(Clone, Debug, PartialEq)]
pub struct Pass<'a> {
    /// Name; a round of a loop has its number.
    pub name: &'a str,
    /// The name by which [`Shown::after`] means it: of the pass of the file, with the number of the round where it is in a loop.
    pub after: &'a str,
    /// Milliseconds of the device, in the frames in which it ran.
    pub times: Option<&'a Samples>,
    /// Its state.
    pub state: PassState,
    /// Workgroups.
    pub groups: &'a str,
    /// Path and line of its declaration.
    pub place: &'a str,
    /// The resource that it is best known by: what it writes first. Index into [`View::resources`].
    pub output: Option<usize>,
}

/// How a pass touches a resource.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Use {
    /// It reads.
    pub reads: bool,
    /// It writes.
    pub writes: bool,
    /// The first mip that it writes, or else reads.
    pub mip: u32,
    /// The first layer that it writes, or else reads.
    pub layer: u32,
}

/// A target or a buffer.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Resource {
    /// Name.
    pub name: String,
    /// Format and extent, or bytes.
    pub about: String,
    /// Bytes of all its copies; 0 where it is not created.
    pub bytes: u64,
    /// Where its memory is: of its own, in a shared block, the supplier's.
    pub memory: String,
    /// Number of the shared block that it lies in.
    pub block: Option<u32>,
    /// Path and line of its declaration.
    pub place: String,
    /// It cannot be shown as a picture that says anything: a world.
    pub opaque: bool,
    /// How each pass touches it, in the order of [`View::passes`].
    pub uses: Vec<Use>,
}

/// A target as a pass has left it, small.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Thumbnail {
    /// Index into [`View::passes`].
    pub pass: usize,
    /// Index into [`View::resources`].
    pub resource: usize,
    /// Another picture has another number.
    pub number: u64,
    /// Pixels along each axis.
    pub size: [usize; 2],
    /// Red, green, blue, alpha, row by row from the top; sRGB-encoded.
    pub rgba: Arc<[u8]>,
}

/// The types of components.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[allow(missing_docs, reason = "each is the type of its name")]
pub enum ComponentKind {
    Bool,
    Int,
    Uint,
    #[default]
    Float,
}

/// A live value.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Param {
    /// Name.
    pub name: String,
    /// Text beside the widget.
    pub label: String,
    /// The type of its components.
    pub kind: ComponentKind,
    /// Components of its value.
    pub value: Vec<f64>,
    /// Components of the value in the file.
    pub default: Vec<f64>,
    /// Smallest and largest component.
    pub range: Option<[f64; 2]>,
    /// Step of a slider.
    pub step: Option<f64>,
    /// Its purpose, in a sentence.
    pub tooltip: Option<String>,
    /// Unit of the value.
    pub unit: Option<String>,
    /// Title of the group that it stands in.
    pub group: Option<String>,
    /// Names of the values 0, 1, 2, …
    pub choices: Vec<String>,
    /// Its three or four components are a linear colour.
    pub color: bool,
    /// A demo drives it.
    pub driven: bool,
    /// Project path of the file that its default stands in: the graph's, or one that the graph extends.
    pub file: String,
    /// Path and line of its declaration.
    pub place: String,
}

/// Named values of params.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Preset {
    /// Its name.
    pub name: String,
    /// The params that have other values now: a line for each, with both.
    pub differing: Vec<String>,
}

/// A diagnostic.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Problem {
    /// It is an error, else a warning.
    pub error: bool,
    /// `path:line:column`, where it has a place.
    pub place: Option<String>,
    /// One line.
    pub title: String,
    /// The text as the terminal has it.
    pub text: String,
}

/// World and camera.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct World<'a> {
    /// Project path of the world's file.
    pub path: Option<String>,
    /// The solid voxels; `None` of land that is made around the camera.
    pub solid: Option<Solids>,
    /// Position of the camera in voxels.
    pub position: [f64; 3],
    /// Yaw, pitch and vertical field of view in degrees.
    pub angles: [f64; 3],
    /// Voxels that the camera flies in a second.
    pub speed: f64,
    /// Names of the world's cameras.
    pub cameras: Vec<String>,
    /// How it can be edited.
    pub editing: Editing<'a>,
}

/// The solid voxels of a world.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Solids {
    /// How many there are.
    pub count: u64,
    /// The smallest coordinates among them.
    pub min: [i64; 3],
    /// One past the largest.
    pub max: [i64; 3],
}

/// How texels become colours.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Map {
    /// Index into [`Map::NAMES`].
    pub map: usize,
    /// Values at the ends of the map; `None` finds them by the percentiles of what is shown.
    pub range: Option<[f32; 2]>,
    /// The channel that scalar maps read.
    pub channel: u32,
}

impl Map {
    /// The maps, in the order of the graph language.
    pub const NAMES: [&'static str; 8] = ["color", "raw", "gray", "turbo", "viridis", "normal", "id", "integer"];
}

/// The contents of the shown resource.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Inspected {
    /// The resource at its point of the frame.
    pub shown: Shown,
    /// Format and extent.
    pub about: String,
    /// Mips it has.
    pub mips: u32,
    /// Layers, or slices of the shown mip.
    pub layers: u32,
    /// Names of its channels.
    pub channels: Vec<&'static str>,
    /// The user's own way of showing it.
    pub map: Option<Map>,
    /// The way that is used now, with its range.
    pub used: Option<Map>,
    /// Of the chosen channel.
    pub statistics: Option<Statistics>,
    /// Of each channel, how many values are NaN and how many are infinite.
    pub not_finite: Vec<NotFinite>,
    /// Texels across and down; `[0, 0]` of a buffer.
    pub extent: [u32; 2],
    /// The texel under the cursor.
    pub cursor: Option<Texel>,
    /// The numbers are of an earlier frame than the texels, and those of this one take long.
    pub earlier: bool,
    /// The search that is under way.
    pub looking: Option<Looking>,
    /// The texels that the user has pinned, in what is shown now.
    pub pins: Vec<Pinned>,
    /// Number of the active one.
    pub active: u32,
    /// The active one.
    pub pinned: Option<Texel>,
    /// The active one over the passes of a frame, and over frames.
    pub history: Option<TexelHistory>,
    /// The passes that may write the pinned texel, in their order, as far as they have told; `None` while nobody asks.
    pub writers: Option<Vec<PassWriters>>,
    /// The texels around the pinned one, or else around the one under the cursor.
    pub zoom: Option<Zoom>,
    /// Rows of a buffer.
    pub table: Option<Table>,
}

/// A pinned texel.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Pinned {
    /// Its number, from 1 on.
    pub number: u32,
    /// `None` if the picture has no texels.
    pub texel: Option<Texel>,
}

/// A search through the slices of a target.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Looking {
    /// What it looks for.
    pub sought: Sought,
    /// Slices that it has looked at.
    pub looked: usize,
    /// All slices.
    pub slices: usize,
}

/// One texel.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Texel {
    /// From the top left.
    pub at: [u32; 2],
    /// Of each channel its value, as an integer where it is one, and its bits.
    pub values: Vec<[String; 2]>,
}

/// A texel over the passes of a frame, and over frames.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TexelHistory {
    /// The dispatches of the newest frame that may have written it, in their order.
    pub writes: Vec<PassTexel>,
    /// The chosen channel after each of the last frames that wrote it, oldest first; `None` if it is no finite number.
    pub frames: Vec<Option<f32>>,
}

/// A texel as a pass left it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct PassTexel {
    /// Name of the pass.
    pub pass: String,
    /// Of each channel its value, as an integer where it is one.
    pub values: Vec<String>,
}

/// The writes of a texel by a pass.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct PassWriters {
    /// Name of the pass.
    pub pass: String,
    /// The last frame in which it ran.
    pub frame: u64,
    /// How often it wrote the texel in that frame.
    pub count: u32,
    /// Several invocations wrote it, and the device decides which value is left.
    pub race: bool,
    /// The first writes.
    pub writes: Vec<TexelWriter>,
}

/// A write of a texel.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct TexelWriter {
    /// `path:line`, when the source is known.
    pub place: Option<String>,
    /// `gl_GlobalInvocationID`.
    pub invocation: [u32; 3],
    /// `gl_WorkGroupID`.
    pub workgroup: [u32; 3],
    /// The written value of each channel, as an integer where it is one.
    pub values: Vec<String>,
}

/// A square of texels around one.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Zoom {
    /// The colours of [`Zoom::SIDE`] rows of as many texels, sRGB-encoded; `None` outside of the picture.
    pub colors: Vec<Option<[u8; 3]>>,
}

impl Zoom {
    /// Texels across and down; odd, so that one is at the centre.
    pub const SIDE: u32 = 11;
}

/// Elements of a buffer.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Table {
    /// Names and types of the members.
    pub columns: Vec<String>,
    /// Elements of the whole buffer.
    pub total: u64,
    /// Index of the first row.
    pub first: u64,
    /// Values, a row for each element.
    pub rows: Vec<Vec<String>>,
    /// Names and values of what stands before the first element.
    pub head: Vec<[String; 2]>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn another_mip_is_the_same_point_and_another_frame_is_not() {
        let point = Shown::after("glow", Some("down[3]".to_owned()));
        assert!(Shown { mip: 2, layer: 1, ..point.clone() }.is_at(&point));
        assert!(!Shown { age: 1, ..point.clone() }.is_at(&point) && !Shown::after("glow", None).is_at(&point));
    }
}
