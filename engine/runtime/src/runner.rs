//! Graphs on a device without a session: no file is watched, no device is reopened, and every frame is requested.

use std::sync::Arc;

use raxel_execute::{ExecuteError, Executor, ExecutorOptions};
use raxel_gpu::Device;
use raxel_graph::checked::{Graph, ResourceId};
use raxel_graph::plan::{Observe, Present};

use crate::build::{self, DeviceContext, Selection};
use crate::build_error::BuildError;
use crate::params::Params;
use crate::world::SessionWorld;

/// An executor, with the sources of its graphs on the device: a world is encoded and uploaded once for each layout.
pub struct GraphRunner {
    executor: Executor,
    context: DeviceContext,
}

/// The settings of a graph's run.
#[derive(Clone, Debug)]
pub struct Setup {
    /// Extent of the output in pixels.
    pub output: [u32; 2],
    /// Resources that stay readable at the end of a frame, besides the presented one.
    pub pinned: Vec<ResourceId>,
    /// Whether transient resources may share memory.
    pub alias: bool,
}

impl GraphRunner {
    /// On a device, with nothing to run yet.
    pub fn new(device: Arc<Device>, options: ExecutorOptions) -> Result<GraphRunner, ExecuteError> {
        let executor = Executor::new(device, options)?;
        let context = DeviceContext::of(&executor);
        Ok(GraphRunner { executor, context })
    }

    /// Runs a graph over a world from the next frame on, with conditions and loops as the params say. Every resource starts at its `init`.
    pub fn load(
        &mut self,
        graph: &Arc<Graph>,
        world: &SessionWorld,
        params: &Params,
        setup: Setup,
    ) -> Result<(), BuildError> {
        let selection = Selection {
            graph: graph.name.clone(),
            output: setup.output,
            present: Present::of(graph.present),
            pinned: setup.pinned,
            observe: Observe::Shown,
            facts: build::facts(graph, world, params, self.executor.device().capabilities()),
            counts: build::counts(graph, params),
            alias: setup.alias,
        };
        let assembly = build::assemble(graph, world, &selection, &self.context)?;
        let prepared = build::prepare(&assembly, &self.context)?;
        self.executor.swap(prepared);
        self.executor.reset_history();
        Ok(())
    }

    /// The executor, which runs frames and reads results.
    pub fn executor(&mut self) -> &mut Executor {
        &mut self.executor
    }

    /// Takes the layouts of all worlds from the device, once nothing that runs binds them.
    pub fn forget_worlds(&mut self) {
        self.context.sources.clear();
    }
}
