//! What a session tells about edits.

use raxel_diagnostics::{Diagnostic, SourceMap};
use raxel_execute::SwapReport;

use crate::session::OpenError;

/// Something that happened apart from frames.
#[derive(Debug)]
pub enum ReloadEvent {
    /// An edit is running.
    Reloaded(Reloaded),
    /// An edit is wrong; what ran before runs on.
    Failed(Failed),
    /// Another size made targets or buffers with history anew: what frames before had left in them is gone. Said once for each of them.
    HistoryCleared {
        /// Extent of the output in pixels.
        size: [u32; 2],
        /// Their names.
        resources: Vec<String>,
    },
    /// What a session waits for ([`crate::Options::wait`]) has mistakes, at first and then whenever they are others.
    NotOpened(OpenError),
    /// The mistakes that it waited for are mended, and it runs, as if it had been opened just now: only the window's extent is as it was.
    Opened,
    /// The device was lost and opened anew.
    DeviceRebuilt {
        /// The pass that the device worked on, if it is known.
        suspect: Option<String>,
        /// That pass is switched off until its shader or its part of the graph changes; else it has changed already.
        off: bool,
        /// Milliseconds from the loss to the new plan.
        milliseconds: f64,
    },
}

/// An edit that is running.
#[derive(Debug)]
pub struct Reloaded {
    /// Counts the edits of a session, wrong ones included; what was opened is 0.
    pub generation: u64,
    /// Project paths of the files that changed.
    pub changed: Vec<String>,
    /// Another graph, world or demo runs than before ([`crate::Session::open_file`]), and it begins at its first frame.
    pub opened: bool,
    /// What was built anew.
    pub rebuilt: Rebuilt,
    /// What became of the contents of targets and buffers.
    pub resources: SwapReport,
    /// Milliseconds from the moment the edit was seen to be finished until it was swapped in.
    pub milliseconds: f64,
    /// What of it was spent on what.
    pub stages: Stages,
    /// Warnings.
    pub diagnostics: Vec<Diagnostic>,
    /// The texts that they point into.
    pub texts: SourceMap,
}

/// What the time of an edit is spent on, one after the other. What drivers leave to the first frame is not in it: lavapipe makes machine code of
/// a shader when it is first dispatched.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Stages {
    /// Milliseconds to load what depends on the changed files: shaders are compiled to modules and reflected, graphs checked, worlds built.
    pub load: f64,
    /// Milliseconds for a plan with its sources and pipelines.
    pub plan: f64,
    /// Milliseconds for images, buffers and descriptors.
    pub prepare: f64,
}

/// What an edit made necessary.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Rebuilt {
    /// The graph.
    pub graph: bool,
    /// The world.
    pub world: bool,
    /// The demo.
    pub demo: bool,
    /// Shaders whose module is new, by project path.
    pub shaders: Vec<String>,
}

/// An edit that is wrong.
#[derive(Debug)]
pub struct Failed {
    /// Counts the edits of a session.
    pub generation: u64,
    /// Project paths of the files that changed.
    pub changed: Vec<String>,
    /// Everything that is wrong, in all files.
    pub diagnostics: Vec<Diagnostic>,
    /// The texts that they point into.
    pub texts: SourceMap,
}
