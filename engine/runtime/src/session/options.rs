//! What a session opens, and how.

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

/// What is opened, and how. Start from [`Options::default`] and change what matters.
#[derive(Clone)]
#[allow(clippy::struct_excessive_bools, reason = "each is a switch of its own, named where it is set")]
pub struct Options {
    /// The project's folder, or any path inside it. The current folder when `None` and no file is named.
    pub project: Option<PathBuf>,
    /// The graph's file, relative to the current folder or to the project; the demo's, or the project's default, when `None`.
    pub graph: Option<PathBuf>,
    /// The world's file; the demo's, or the project's default, when `None`.
    pub world: Option<PathBuf>,
    /// A demo to run.
    pub demo: Option<PathBuf>,
    /// Extent of the window in pixels.
    pub size: [u32; 2],
    /// Pixels of the output for each pixel of the window, along each axis.
    pub scale: f64,
    /// Seconds of a frame; `None` follows the wall clock. `1.0 / 60.0` is a sixtieth exactly ([`raxel_execute::moment::Fraction::of`]).
    pub step: Option<f64>,
    /// The debug target: the graph's own when empty.
    pub debug_target: DebugTarget,
    /// Resources that can be read at the end of a frame, besides the one shown.
    pub pinned: Vec<String>,
    /// What else can be read: everything, or for speed only what is shown. No later frame depends on it.
    pub observe: Observe,
    /// How much it matters that a shader does not use a binding, a block or a member that its graph gives it. With a warning one may take a term of
    /// a shader out and put it back while frames run, and no state is lost.
    pub unused: Severity,
    /// Takes the place of the layout of every buffer that the graph fills with a world; `None` keeps the graph's own.
    pub layout: Option<Layout>,
    /// The Vulkan device: a part of its name, or its number.
    pub device: Option<String>,
    /// Whether the validation layer looks on.
    pub validation: Validation,
    /// Passes whose inputs did not change are not run again.
    pub memo: bool,
    /// Transient resources may share memory.
    pub alias: bool,
    /// A frame that takes longer means that the device hangs; on a software device six times as long.
    pub watchdog: Duration,
    /// What is done with the save of a world that has one.
    pub saves: Saves,
    /// What the project's manifest says in place of these options, so that its mistakes count; `None`: only which graph and which world run
    /// where none is named.
    pub manifest: Option<ManifestDefaults>,
    /// Files with mistakes are waited for: the session opens and runs nothing ([`Session::is_waiting`]) until they are mended, and opens them
    /// then ([`Session::poll_reload`]). Else opening them is an error.
    pub wait: bool,
    /// Files are watched, and edits swapped in by [`Session::poll_reload`].
    pub watch: bool,
    /// Files are looked at now and then, even where the system can tell of changes (network folders).
    pub poll: bool,
    /// Called, on another thread, when there is something for [`Session::poll_reload`].
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
    /// Puts what a manifest says in place of what was not chosen.
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

/// Which options a project's manifest decides, where it says something of them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ManifestDefaults {
    /// The demo, where no graph, no world and no demo is named.
    pub demo: bool,
    /// The extent of the window.
    pub size: bool,
    /// Pixels of the output for each pixel of the window.
    pub scale: bool,
}
