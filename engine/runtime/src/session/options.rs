//! The files of a session, and its settings.

use std::path::PathBuf;
use std::time::Duration;

use raxel_diagnostics::Severity;
use raxel_execute::ExecutorOptions;
use raxel_gpu::Validation;
use raxel_graph::plan::Observe;
use raxel_layouts::Layout;

#[cfg(doc)]
use super::Session;
use crate::debug_target::DebugTarget;
use crate::editing::Saves;
use crate::manifest::Manifest;
use crate::project::Project;
use crate::reload::Waker;

/// The files of a session, and its settings. Start from [`Options::default`] and change some fields.
#[derive(Clone)]
#[allow(clippy::struct_excessive_bools, reason = "each is a switch of its own, named where it is set")]
pub struct Options {
    /// The project's folder, or any path inside it. `None`: the project around the named file, or around the current folder.
    pub project: Option<PathBuf>,
    /// The graph's file, relative to the current folder or to the project. `None`: the demo's graph, or the project's default.
    pub graph: Option<PathBuf>,
    /// The world's file. `None`: the demo's world, or the project's default.
    pub world: Option<PathBuf>,
    /// The demo to run.
    pub demo: Option<PathBuf>,
    /// Extent of the window in pixels.
    pub size: [u32; 2],
    /// Pixels of the output for each pixel of the window, along each axis.
    pub scale: f64,
    /// Seconds for each frame. `None` follows the wall clock. `1.0 / 60.0` means exactly one sixtieth
    /// ([`raxel_execute::moment::Fraction::of`]).
    pub step: Option<f64>,
    /// The debug target. An empty one stands for the target that the graph presents.
    pub debug_target: DebugTarget,
    /// Names of resources that stay readable at the end of a frame, besides the one shown.
    pub pinned: Vec<String>,
    /// Other resources that can be read: all, or, for speed, only the shown one. Frames compute the same either way.
    pub observe: Observe,
    /// How raxel reports a binding, a block or a member that the graph gives and the shader does not use. With a warning, you can comment
    /// out a term of a shader and put it back without a loss of state.
    pub unused: Severity,
    /// Whether shaders check the bounds of their accesses ([`Session::check_bounds`]).
    pub check_bounds: bool,
    /// Whether shaders record their writes of a texel ([`Session::record_writes`]).
    pub record_writes: bool,
    /// Replaces the layout of every buffer that holds a world. `None` keeps the layouts of the graph.
    pub layout: Option<Layout>,
    /// The Vulkan device: a part of its name, or its number.
    pub device: Option<String>,
    /// Whether to load the validation layer.
    pub validation: Validation,
    /// Whether to skip passes whose inputs did not change.
    pub memo: bool,
    /// Whether transient resources may share memory.
    pub alias: bool,
    /// Longest time in which the device may finish no pass before it counts as lost. A software device gets six times as long.
    pub watchdog: Duration,
    /// The use of the save of a world.
    pub saves: Saves,
    /// Which options the project's manifest may set; its mistakes are then errors. `None`: the manifest sets only the default graph and
    /// world.
    pub manifest: Option<ManifestDefaults>,
    /// Whether to open a session even if files have mistakes. The session then runs nothing ([`Session::is_waiting`]) until the mistakes
    /// are corrected and [`Session::poll_reload`] opens the files. Without this option, such files are an error.
    pub wait: bool,
    /// Whether to watch files, so that [`Session::poll_reload`] swaps edits in.
    pub watch: bool,
    /// Whether to also check files from time to time, for folders without change notifications (network folders).
    pub poll: bool,
    /// Called on another thread when [`Session::poll_reload`] has something to do.
    pub waker: Option<Waker>,
}

impl Default for Options {
    /// The current folder's project at 1280 × 720, sixty frames a second, without watching its files.
    fn default() -> Self {
        Self {
            project: None,
            graph: None,
            world: None,
            demo: None,
            size: [1280, 720],
            scale: 1.0,
            step: Some(1.0 / 60.0),
            debug_target: DebugTarget::default(),
            pinned: Vec::new(),
            observe: Observe::Everything,
            unused: Severity::Error,
            check_bounds: false,
            record_writes: false,
            layout: None,
            device: None,
            validation: Validation::Off,
            memo: true,
            alias: true,
            watchdog: ExecutorOptions::default().watchdog,
            saves: Saves::default(),
            manifest: None,
            wait: false,
            watch: false,
            poll: false,
            waker: None,
        }
    }
}

impl Options {
    /// Fills options that were not chosen from the manifest.
    pub(super) fn fill_in(&mut self, defaults: ManifestDefaults, manifest: &Manifest, project: &Project) {
        if defaults.demo && self.graph.is_none() && self.world.is_none() && self.demo.is_none() {
            self.demo = manifest.demo.as_ref().map(|demo| project.on_disk(demo));
        }
        if defaults.size {
            self.size = manifest.size.unwrap_or(self.size);
        }
        if defaults.scale {
            self.scale = manifest.scale.unwrap_or(self.scale);
        }
    }
}

/// Which options a project's manifest may set.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ManifestDefaults {
    /// The demo, if no graph, world or demo is named.
    pub demo: bool,
    /// The extent of the window.
    pub size: bool,
    /// Pixels of the output for each pixel of the window.
    pub scale: bool,
}
