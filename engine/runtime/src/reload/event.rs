//! Events of a session: edits of files, lost histories, lost devices.

use raxel_diagnostics::{Diagnostic, SourceMap};
use raxel_execute::SwapReport;

use crate::session::OpenError;

/// Something that happened between frames.
#[derive(Debug)]
pub enum ReloadEvent {
    /// An edit was swapped in.
    Reloaded(Reloaded),
    /// An edit has mistakes. The old files run on.
    Failed(Failed),
    /// A new size replaced targets or buffers with history, so their contents are lost. Sent once for each of them.
    HistoryCleared {
        /// Extent of the output in pixels.
        size: [u32; 2],
        /// Their names.
        resources: Vec<String>,
    },
    /// The files of a waiting session ([`crate::Options::wait`]) have mistakes. Sent at first, and whenever the mistakes change.
    NotOpened(OpenError),
    /// The mistakes of a waiting session are corrected. The session now runs as if it had just been opened, with the same window extent.
    Opened,
    /// The device was lost, and raxel opened it again.
    DeviceRebuilt {
        /// The pass that was running, if known.
        suspect: Option<String>,
        /// Whether that pass is switched off until its shader or its part of the graph changes. False if it has changed already.
        off: bool,
        /// Milliseconds from the loss to the new plan.
        milliseconds: f64,
    },
}

/// An edit that was swapped in.
#[derive(Debug)]
pub struct Reloaded {
    /// Number of the edit, wrong edits included. The files that were opened are generation 0.
    pub generation: u64,
    /// Project paths of the files that changed.
    pub changed: Vec<String>,
    /// Another graph, world or demo runs than before ([`crate::Session::open_file`]), and it begins at its first frame.
    pub opened: bool,
    /// The rebuilt parts.
    pub rebuilt: Rebuilt,
    /// Which targets and buffers kept their contents.
    pub resources: SwapReport,
    /// Milliseconds from the moment at which the watcher found the save finished to the swap.
    pub milliseconds: f64,
    /// Parts of this time.
    pub stages: Stages,
    /// Warnings.
    pub diagnostics: Vec<Diagnostic>,
    /// The texts that they point into.
    pub texts: SourceMap,
}

/// Parts of the time of an edit, in order. They do not include work that the driver leaves to the first frame, such as the machine code
/// that lavapipe makes when it first dispatches a shader.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Stages {
    /// Milliseconds to load the dependents of the changed files once the edit is finished: shaders that were not compiled while it was waited for are
    /// compiled to modules and reflected, graphs checked, worlds built.
    pub load: f64,
    /// Milliseconds for a plan with its sources and pipelines.
    pub plan: f64,
    /// Milliseconds for images, buffers and descriptors.
    pub prepare: f64,
}

/// The parts that an edit rebuilt.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Rebuilt {
    /// The graph.
    pub graph: bool,
    /// The world.
    pub world: bool,
    /// The demo.
    pub demo: bool,
    /// Project paths of shaders with a new module.
    pub shaders: Vec<String>,
}

/// An edit with mistakes.
#[derive(Debug)]
pub struct Failed {
    /// Number of the edit.
    pub generation: u64,
    /// Project paths of the files that changed.
    pub changed: Vec<String>,
    /// All mistakes, in all files.
    pub diagnostics: Vec<Diagnostic>,
    /// The texts that they point into.
    pub texts: SourceMap,
}
