//! A session: an open project that runs. Programs start here; the command line and the window use the same type.

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
mod writers;

use std::sync::Arc;

pub use capture::CaptureError;
pub use edit::EditFailure;
pub use error::{FrameError, OpenError, ReadError};
pub use options::{ManifestDefaults, Options};
pub use raxel_gpu::Validation;
pub use take::{TakeIdentity, TakeSoFar};

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
    /// Events since [`Session::poll_reload`].
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

    /// The graph that the demo shows at a time of the clock, in seconds.
    pub fn graph_at(&self, seconds: impl Into<Moment>) -> &Arc<Graph> {
        let state = &self.files.state;
        let demo = self.playback.demo.driving().filter(|_| !state.named.graph);
        let part = demo.and_then(|demo| state.graph_at(&demo.graph_at(seconds).value));
        part.and_then(|part| part.result.as_ref().ok()).unwrap_or(&self.renderer.graph)
    }

    /// Project path of the graph's file.
    pub fn graph_path(&self) -> &str {
        &self.files.state.graph_path
    }

    /// The world that the graph runs over.
    pub fn world(&self) -> &Arc<SessionWorld> {
        &self.world.shown
    }

    /// The demo of the session, if there is one.
    pub fn demo(&self) -> Option<&Arc<Demo>> {
        self.playback.demo.demo.as_ref()
    }

    /// The plan that runs.
    pub fn plan(&self) -> Option<&Arc<Plan>> {
        self.renderer.executor.plan()
    }

    /// Whether no plan could be made for the wanted size, debug target or conditions. Then the old plan runs on.
    pub fn is_refused(&self) -> bool {
        self.renderer.plans.is_refused()
    }

    /// While an edit is built: the pass whose pipeline the driver has compiled longest, if for more than a second.
    pub fn compiling(&self) -> Option<raxel_execute::Compiling> {
        self.renderer.context.builder.compiling()
    }

    /// The device. [`ReloadEvent::DeviceRebuilt`] replaces it.
    pub fn device(&self) -> &Arc<raxel_gpu::Device> {
        self.renderer.executor.device()
    }

    /// Warnings about the files that run.
    pub fn warnings(&self) -> &[Diagnostic] {
        &self.files.warnings
    }

    /// The texts of the files that run. Places of diagnostics point into them.
    pub fn texts(&self) -> &SourceMap {
        &self.files.texts
    }
}
