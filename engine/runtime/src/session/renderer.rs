//! The running part on the device: a graph, its plan, and the part of it that is shown.

use std::sync::Arc;

use raxel_execute::{Executor, ExecutorOptions, Pipelined, Region};
use raxel_graph::checked::{Display, Graph};
use raxel_graph::plan::ResourcePlan;

use super::Options;
use super::change_tracker::ChangeTracker;
use super::counter_warnings::CounterWarnings;
use super::history::History;
use super::plans::Plans;
use super::prints::Prints;
use super::recover::Budget;
use super::switched_off::SwitchedOff;
use super::writers::Writers;
use crate::build::{self, Assembly, DeviceContext, Selection};
use crate::build_error::BuildError;
use crate::debug_target::DebugTarget;
use crate::present::Viewport;
use crate::reload::ReloadEvent;
use crate::world::SessionWorld;

/// A graph on a device.
pub(super) struct Renderer {
    pub executor: Executor,
    pub context: DeviceContext,
    pub recovery: Budget,
    pub graph: Arc<Graph>,
    pub plans: Plans,
    pub shown: Shown,
    pub off: SwitchedOff,
    pub history: History,
    pub still: ChangeTracker,
    /// Counts of passes that should be 0.
    pub counters: CounterWarnings,
    pub prints: Prints,
    pub writers: Writers,
}

/// The shown part of a graph, and its size.
pub(super) struct Shown {
    pub viewport: Viewport,
    /// The resource that the user shows.
    pub debug_target: DebugTarget,
    /// How, instead of the graph's way.
    pub display: Option<Display>,
    /// Which part of it.
    pub region: Region,
    /// Resources that can be read at the end of a frame, besides the one shown.
    pub pinned: Vec<String>,
    /// The resource that the debug target is compared with as it goes on; it is pinned, too.
    pub live: Option<String>,
}

impl Shown {
    /// Everything that can be read at the end of a frame, besides the debug target.
    pub(crate) fn kept(&self) -> Vec<String> {
        self.pinned.iter().chain(&self.live).cloned().collect()
    }
}

impl Renderer {
    /// Runs the plan of a graph from the next frame on.
    pub(crate) fn new(
        mut executor: Executor,
        context: DeviceContext,
        graph: Arc<Graph>,
        assembly: &Assembly,
        selection: Selection,
        shown: Shown,
    ) -> Result<Self, BuildError> {
        executor.swap(build::prepare(assembly, &context)?);
        // Now and not only at the end: a window may be killed.
        executor.device().keep_pipelines();
        Ok(Self {
            executor,
            context,
            recovery: Budget::default(),
            graph,
            plans: Plans::new(selection, assembly.plan.clone()),
            shown,
            off: SwitchedOff::default(),
            history: History::default(),
            still: ChangeTracker::default(),
            counters: CounterWarnings::default(),
            prints: Prints::default(),
            writers: Writers::default(),
        })
    }

    /// Swaps in a plan of a graph for another selection over the same world. Says which histories another size has cleared.
    pub(crate) fn plan_for(
        &mut self,
        graph: &Arc<Graph>,
        world: &SessionWorld,
        selection: &Selection,
    ) -> Result<Option<ReloadEvent>, BuildError> {
        let assembly = match self.plans.find(selection) {
            Some(plan) => build::sources(&plan, world, &self.context).map(|sources| Assembly {
                plan,
                sources,
                pipelined: Pipelined::default(),
            }),
            None => build::assemble(graph, world, selection, &self.context),
        }?;
        let prepared = build::prepare(&assembly, &self.context)?;
        let running = &self.plans.running;
        let resized = running.graph == selection.graph && running.output != selection.output;
        let before = if resized { self.kept_over_frames() } else { Vec::new() };
        let swapped = self.executor.swap(prepared);
        let cleared: Vec<String> = before.into_iter().filter(|name| swapped.created.contains(name)).collect();
        self.plans.remember(selection.clone(), assembly.plan);
        let news = self.history.is_news(&cleared);
        Ok(news.then_some(ReloadEvent::HistoryCleared { size: selection.output, resources: cleared }))
    }

    /// Names of the resources that the running plan keeps from frame to frame, without sources.
    fn kept_over_frames(&self) -> Vec<String> {
        let Some(plan) = self.executor.plan() else { return Vec::new() };
        let carries = |resource: &&ResourcePlan| resource.copies > 1;
        let names = plan.resources.iter().filter(carries).map(|r| plan.graph.resource(r.resource).name.clone());
        names.collect()
    }

    /// Everything that passes keep from frame to frame starts over.
    pub(crate) fn reset(&mut self) {
        self.executor.reset_history();
        self.still.reset();
        self.history.reset();
    }
}

/// How many times the watchdog's limit a device is given. A software device may honestly take as long as a GPU that hangs.
pub(super) fn patience(device: &raxel_gpu::Device) -> u32 {
    if device.capabilities().kind == raxel_gpu::DeviceKind::Cpu { 6 } else { 1 }
}

/// Opens an executor on a device.
pub(super) fn start(
    device: &Arc<raxel_gpu::Device>,
    options: &Options,
) -> Result<(Executor, DeviceContext), raxel_execute::ExecuteError> {
    let watchdog = options.watchdog * patience(device);
    let executor_options = ExecutorOptions { memo: options.memo, watchdog, ..ExecutorOptions::default() };
    let executor = Executor::new(device.clone(), executor_options)?;
    // A session that follows the wall clock never waits for its world.
    let context = DeviceContext::with_worlds(&executor, options.step.is_none());
    Ok((executor, context))
}

/// Opens a device as the options say.
pub(super) fn open_device(options: &Options) -> Result<Arc<raxel_gpu::Device>, raxel_gpu::Error> {
    raxel_gpu::Device::new(&raxel_gpu::DeviceOptions { device: options.device.clone(), validation: options.validation })
}
