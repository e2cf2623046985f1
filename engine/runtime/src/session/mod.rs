//! A session: a project that is open and runs. The library's front door; the command line and the window drive the same type.

mod capture;
mod change_tracker;
mod changed;
mod counter_warnings;
mod drive;
mod edit;
mod error;
mod files;
mod frame;
mod graphs;
mod history;
mod members;
mod open;
mod options;
mod plans;
mod playback;
mod prints;
mod read;
mod recover;
mod reload;
mod renderer;
mod reports;
mod retry;
mod shader_output;
mod switched_off;
mod take;
mod waiting;
mod world;

use std::sync::Arc;

pub use capture::CaptureError;
pub use edit::EditFailure;
pub use error::{FrameError, OpenError, ReadError};
pub use options::{ManifestDefaults, Options};
pub use raxel_gpu::Validation;

use raxel_diagnostics::{Diagnostic, SourceMap};
use raxel_execute::moment::Moment;
use raxel_graph::checked::Graph;
use raxel_graph::plan::Plan;

use self::files::ProjectFiles;
use self::playback::Playback;
use self::renderer::Renderer;
use self::waiting::Waiting;
use self::world::WorldState;
use crate::project::Project;
use crate::reload::ReloadEvent;
use crate::timeline::Demo;
use crate::world::SessionWorld;

/// An open project. See the crate's example.
pub struct Session {
    options: Options,
    files: ProjectFiles,
    playback: Playback,
    world: WorldState,
    renderer: Renderer,
    /// Nothing runs until mistakes are mended.
    waiting: Option<Waiting>,
    /// What has happened since [`Session::poll_reload`].
    events: Vec<ReloadEvent>,
}

impl Session {
    /// The project.
    pub fn project(&self) -> &Project {
        &self.files.project
    }

    /// The graph that runs.
    pub fn graph(&self) -> &Arc<Graph> {
        &self.renderer.graph
    }

    /// The graph at so many seconds on the clock, as the demo has it.
    pub fn graph_at(&self, seconds: impl Into<Moment>) -> &Arc<Graph> {
        let state = &self.files.state;
        let demo = self.playback.demo.driving().filter(|_| !state.named.graph);
        let part = demo.and_then(|demo| state.graph_at(&demo.graph_at(seconds).value));
        part.and_then(|part| part.result.as_ref().ok()).unwrap_or(&self.renderer.graph)
    }

    /// Project path of its file.
    pub fn graph_path(&self) -> &str {
        &self.files.state.graph_path
    }

    /// The world that it runs over.
    pub fn world(&self) -> &Arc<SessionWorld> {
        &self.world.shown
    }

    /// The demo that drives, if there is one.
    pub fn demo(&self) -> Option<&Arc<Demo>> {
        self.playback.demo.demo.as_ref()
    }

    /// The plan that runs.
    pub fn plan(&self) -> Option<&Arc<Plan>> {
        self.renderer.executor.plan()
    }

    /// Whether no plan could be made for the size, debug target or conditions that are wanted, and the plan before runs on.
    pub fn is_refused(&self) -> bool {
        self.renderer.plans.is_refused()
    }

    /// The pass whose pipeline the driver has worked on longest, if it has for a second: of an edit that is not swapped in yet.
    pub fn compiling(&self) -> Option<raxel_execute::Compiling> {
        self.renderer.context.builder.compiling()
    }

    /// The device. It is another one after [`ReloadEvent::DeviceRebuilt`].
    pub fn device(&self) -> &Arc<raxel_gpu::Device> {
        self.renderer.executor.device()
    }

    /// Warnings of what runs.
    pub fn warnings(&self) -> &[Diagnostic] {
        &self.files.warnings
    }

    /// The texts of what runs, which its warnings and places point into.
    pub fn texts(&self) -> &SourceMap {
        &self.files.texts
    }
}
