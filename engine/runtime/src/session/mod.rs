//! A session: a project that is open and runs. The library's front door; the command line and the window drive the same type.

mod capture;
mod change_tracker;
mod changed;
mod counter_warnings;
mod drive;
mod edit;
mod error;
mod frame;
mod graphs;
mod history;
mod open;
mod prints;
mod recover;
mod reload;
mod retry;
mod shader_output;

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

pub use capture::CaptureError;
pub use edit::EditFailure;
pub use error::{FrameError, OpenError, ReadError};
pub use raxel_gpu::Validation;

use raxel_diagnostics::{Diagnostic, Severity, SourceMap};
use raxel_execute::moment::Moment;
use raxel_execute::{Executor, ExecutorOptions, Override, Region, Suspect};
use raxel_graph::checked::{Display, Graph, ParamId, PassId, Value};
use raxel_graph::plan::{Observe, Plan};
use raxel_layouts::Layout;

use crate::build::{DeviceContext, Selection};
use crate::camera::Camera;
use crate::clock::Clock;
use crate::debug_target::DebugTarget;
use crate::editing::{Editing, Saves};
use crate::load::Loader;
use crate::params::Params;
use crate::present::Viewport;
use crate::project::Project;
use crate::reload::builder::Reloader;
use crate::reload::project_state::ProjectState;
use crate::reload::{ReloadEvent, Waker};
use crate::timeline::Demo;
use crate::world::SessionWorld;

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
            watch: false,
            poll: false,
            waker: None,
        }
    }
}

/// An open project. See the crate's example.
pub struct Session {
    project: Project,
    options: Options,
    loader: Arc<Loader>,
    reloader: Option<Reloader>,

    state: ProjectState,
    graph: Arc<Graph>,
    world: Arc<SessionWorld>,
    editing: Editing,
    collected: shader_output::ShaderOutput,
    changed: changed::Changed,
    warned: counter_warnings::CounterWarnings,
    prints: prints::Prints,
    demo: Option<Arc<Demo>>,
    texts: SourceMap,
    warnings: Vec<Diagnostic>,

    context: DeviceContext,
    executor: Executor,
    device: Arc<raxel_gpu::Device>,
    recovery: recover::Budget,

    /// What the running plan was made for.
    selection: Selection,
    /// What no plan could be made for; said once, and not tried again unless the device refused it.
    refused: Option<Selection>,
    /// When what the device refused is tried again.
    retry: retry::Retry,
    /// The graph of the demo that no plan could be made for; said once, and not tried again until an edit.
    refused_graph: Option<String>,
    /// Something was changed that a plan depends on.
    needs_replan: bool,
    /// Params that conditions of passes ask for, with the values for which the plan was made.
    condition_params: Vec<(ParamId, Value)>,
    plans: Vec<(Selection, Arc<Plan>)>,
    viewport: Viewport,
    /// What the user wants shown.
    debug_target: DebugTarget,
    /// How, instead of as the graph says.
    display: Option<Display>,
    /// Which part of it.
    region: Region,
    pinned: Vec<String>,

    clock: Clock,
    camera: Camera,
    previous_camera: Camera,
    cursor: Option<[i32; 2]>,
    /// Shift of all rays in pixels, right and down.
    subpixel: [f64; 2],
    still: change_tracker::ChangeTracker,
    history: history::History,
    params: Params,
    /// Values of the params in this frame: the user's, under those of the demo.
    values: Vec<Value>,
    pushes: BTreeMap<(String, String), Value>,
    overrides: Vec<Override>,
    /// Passes switched off after a loss of the device.
    switched_off: Vec<Suspect>,
    disabled: Vec<PassId>,
    /// What the demo wanted shown in the last frame.
    demo_target: Option<DebugTarget>,
    /// The demo does not change what is shown.
    target_held: bool,
    /// The user moved: the demo no longer drives.
    taken_over: bool,
    events: Vec<ReloadEvent>,
}

impl Session {
    /// The project.
    pub fn project(&self) -> &Project {
        &self.project
    }

    /// The graph that runs.
    pub fn graph(&self) -> &Arc<Graph> {
        &self.graph
    }

    /// The graph at so many seconds on the clock, as the demo has it.
    pub fn graph_at(&self, seconds: impl Into<Moment>) -> &Arc<Graph> {
        let demo = self.demo.as_ref().filter(|_| !self.taken_over && !self.state.named.graph);
        let part = demo.and_then(|demo| self.state.graph_at(&demo.graph_at(seconds).value));
        part.and_then(|part| part.result.as_ref().ok()).unwrap_or(&self.graph)
    }

    /// Project path of its file.
    pub fn graph_path(&self) -> &str {
        &self.state.graph_path
    }

    /// The world that it runs over.
    pub fn world(&self) -> &Arc<SessionWorld> {
        &self.world
    }

    /// The demo that drives, if there is one.
    pub fn demo(&self) -> Option<&Arc<Demo>> {
        self.demo.as_ref()
    }

    /// The plan that runs.
    pub fn plan(&self) -> Option<&Arc<Plan>> {
        self.executor.plan()
    }

    /// Whether no plan could be made for the size, debug target or conditions that are wanted, and the plan before runs on.
    pub fn is_refused(&self) -> bool {
        self.refused.is_some()
    }

    /// The pass whose pipeline the driver has worked on longest, if it has for a second: of an edit that is not swapped in yet.
    pub fn compiling(&self) -> Option<raxel_execute::Compiling> {
        self.context.builder.compiling()
    }

    /// The device. It is another one after [`ReloadEvent::DeviceRebuilt`].
    pub fn device(&self) -> &Arc<raxel_gpu::Device> {
        &self.device
    }

    /// Warnings of what runs.
    pub fn warnings(&self) -> &[Diagnostic] {
        &self.warnings
    }

    /// The texts of what runs, which its warnings and places point into.
    pub fn texts(&self) -> &SourceMap {
        &self.texts
    }
}
