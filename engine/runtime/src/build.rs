//! From a graph to a plan with its buffers: the steps that opening, reloading and replanning share. Nothing here runs a frame.

use std::collections::BTreeMap;
use std::sync::Arc;

use raxel_diagnostics::{Diagnostic, Span, codes};
use raxel_execute::{self as execute, ExecuteError, Executor};
use raxel_gpu::Capabilities;
use raxel_graph::checked::{Fact, Graph, ParamId, ResourceId, Rounds, count_of};
use raxel_graph::plan::{DeviceLimits, Observe, Plan, PlanInput, Present, SourceSize};
use raxel_layouts::Layout;
use raxel_world::Bounds;

use crate::build_error::BuildError;
use crate::params::Params;
use crate::sources::{OnDevice, SourceName, check_instances};
use crate::world::SessionWorld;

/// The inputs of a plan, apart from the files.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Selection {
    /// Project path of the graph.
    pub graph: String,
    /// Extent of the output in pixels.
    pub output: [u32; 2],
    /// The presented resource.
    pub present: Present,
    /// Resources that stay readable at the end of a frame.
    pub pinned: Vec<ResourceId>,
    /// Other resources that can be read at the end of a frame.
    pub observe: Observe,
    /// Whether each fact that a pass asks for holds.
    pub facts: Vec<(Fact, bool)>,
    /// Rounds of the loops that follow a param.
    pub counts: Vec<(ParamId, u32)>,
    /// Whether transient resources may share memory.
    pub alias: bool,
}

/// The facts that the passes of a graph ask for, and whether they hold on a device.
pub(crate) fn facts(graph: &Graph, world: &SessionWorld, params: &Params, device: &Capabilities) -> Vec<(Fact, bool)> {
    let mut facts: Vec<(Fact, bool)> = Vec::new();
    for condition in graph.passes.iter().flat_map(|pass| &pass.when) {
        if facts.iter().all(|(fact, _)| *fact != condition.fact) {
            let holds = match condition.fact {
                Fact::Param(id) => params.get(id) == raxel_graph::checked::Value::Bool(true),
                _ => holds_on(device, graph, world, &condition.fact),
            };
            facts.push((condition.fact.clone(), holds));
        }
    }
    facts
}

/// Whether a fact, which is no param, holds for a graph over a world on a device.
pub fn holds_on(device: &Capabilities, graph: &Graph, world: &SessionWorld, fact: &Fact) -> bool {
    match fact {
        Fact::DevicePackets => device.traces_packets() && suits_packets(graph, world),
        Fact::DeviceBallots => device.has_plain_ballots(),
        _ => world.holds(fact),
    }
}

/// Voxels along each axis of the largest world that packets trace: half of their reach, since a tree grows by fours.
const LARGEST_FOR_PACKETS: i64 = 1 << 12;

/// Whether packets can trace the world of a graph.
fn suits_packets(graph: &Graph, world: &SessionWorld) -> bool {
    let Bounds { min, max } = world.bounds();
    let fits = |axis: usize| max[axis] - (min[axis] & !63) <= LARGEST_FOR_PACKETS;
    let mut layouts = graph.source_names().into_iter().filter_map(SourceName::world_layout);
    world.tiles().is_none() && (0..3).all(fits) && layouts.all(|layout| layout == Layout::TREE64)
}

/// The rounds of the loops that follow a param.
pub(crate) fn counts(graph: &Graph, params: &Params) -> Vec<(ParamId, u32)> {
    let mut counts: Vec<(ParamId, u32)> = Vec::new();
    for repeated in &graph.loops {
        if let Rounds::Param(id) = repeated.rounds
            && counts.iter().all(|(known, _)| *known != id)
        {
            counts.extend(count_of(params.get(id)).map(|count| (id, count)));
        }
    }
    counts
}

/// The parts of a device that plans for it need.
#[derive(Clone)]
pub(crate) struct DeviceContext {
    /// Makes a plan's objects.
    pub builder: execute::Builder,
    /// Asks the device about memory.
    pub memory: Arc<execute::DeviceMemory>,
    /// Limits of the device.
    pub limits: DeviceLimits,
    /// The sources on the device.
    pub sources: Arc<OnDevice>,
}

impl DeviceContext {
    /// For the device of an executor, on which there is nothing yet. Streamed worlds are complete before each frame.
    pub(crate) fn of(executor: &Executor) -> Self {
        Self::with_worlds(executor, false)
    }

    /// The same; `live` worlds are loaded while frames run.
    pub(crate) fn with_worlds(executor: &Executor, live: bool) -> Self {
        let device = executor.device();
        Self {
            builder: executor.builder(),
            memory: Arc::new(execute::DeviceMemory(device.clone())),
            limits: execute::limits(device.capabilities()),
            sources: Arc::new(OnDevice::new(live)),
        }
    }
}

/// A plan with the sources it needs.
pub(crate) struct Assembly {
    /// The plan.
    pub plan: Arc<Plan>,
    /// The sources.
    pub sources: execute::Sources,
    /// The plan's pipelines, until it is prepared.
    pub(crate) pipelined: execute::Pipelined,
}

/// Plans a graph, encodes and uploads the layouts that its live passes bind, and has the driver compile them meanwhile.
pub(crate) fn assemble(
    graph: &Arc<Graph>,
    world: &SessionWorld,
    selection: &Selection,
    context: &DeviceContext,
) -> Result<Assembly, BuildError> {
    let _span = tracing::debug_span!("plan").entered();
    let sizes = context.sources.sizes(world);
    let plan = make_plan(graph, world, &sizes, selection, context)?;
    fits(&plan, context.builder.device())?;
    // Only the plan knows which layouts a live pass binds; a world's other layouts are never made. The driver compiles on this thread,
    // which stays from edit to edit. Otherwise, the driver's kept memory would be scattered over the heaps of ended threads.
    let (pipelined, sources) = std::thread::scope(|scope| {
        let sources = scope.spawn(|| sources(&plan, world, context));
        let pipelined = context.builder.compile_pipelines(&plan);
        (pipelined, sources.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)))
    });
    let sources = sources?;
    // The first plan did not know the sizes of the layouts made just now.
    let now = context.sources.sizes(world);
    let plan = if now == sizes { plan } else { make_plan(graph, world, &now, selection, context)? };
    Ok(Assembly { plan: Arc::new(plan), sources, pipelined })
}

/// A plan's sources, made if they are not there yet.
pub(crate) fn sources(
    plan: &Plan,
    world: &SessionWorld,
    context: &DeviceContext,
) -> Result<execute::Sources, BuildError> {
    let mut sources = execute::Sources::default();
    let mut found = Vec::new();
    for resource in &plan.resources {
        let resource = plan.graph.resource(resource.resource);
        if resource.kind.supplied_by() == Some("world.instances") {
            found.extend(check_instances(&plan.graph, world, resource));
        }
        match context.sources.supply(resource, world, &context.builder) {
            Ok(Some(source)) => sources.insert(&resource.name, source),
            Ok(None) => {}
            Err(BuildError::Diagnosed(diagnostics)) => found.extend(diagnostics),
            Err(BuildError::Device(error)) => return Err(refusal(error, &plan.graph)),
        }
    }
    if found.is_empty() { Ok(sources) } else { Err(BuildError::Diagnosed(found)) }
}

fn make_plan(
    graph: &Arc<Graph>,
    world: &SessionWorld,
    sizes: &BTreeMap<String, SourceSize>,
    selection: &Selection,
    context: &DeviceContext,
) -> Result<Plan, BuildError> {
    // A source that is not made yet counts as empty.
    let mut sources: BTreeMap<String, SourceSize> =
        graph.source_names().into_iter().map(|name| (name.to_owned(), SourceSize::default())).collect();
    sources.extend(sizes.iter().map(|(name, size)| (name.clone(), *size)));
    let input = PlanInput {
        output: selection.output,
        present: selection.present,
        pinned: &selection.pinned,
        observe: selection.observe,
        counts: &selection.counts,
        facts: &|fact| selection.facts.iter().any(|(known, holds)| known == fact && *holds),
        sources: &sources,
        world: world.input(),
        memory: &*context.memory,
        alias: selection.alias,
        poison: context.builder.device().capabilities().validated,
        limits: context.limits,
    };
    raxel_graph::plan(graph.clone(), &input).map_err(BuildError::Diagnosed)
}

/// Creates a plan's objects, next to the running ones.
pub(crate) fn prepare(assembly: &Assembly, context: &DeviceContext) -> Result<execute::Prepared, BuildError> {
    let _span = tracing::debug_span!("prepare").entered();
    let Assembly { plan, sources, pipelined: _held } = assembly;
    context.builder.prepare(plan.clone(), sources).map_err(|error| refusal(error, &plan.graph))
}

/// Refuses a plan that the device cannot run, and lists everything that the device lacks.
pub fn fits(plan: &Plan, device: &dyn execute::Abilities) -> Result<(), BuildError> {
    let unfit = execute::unfit(device, plan).map_err(|error| refusal(error, &plan.graph))?;
    let mut found: Vec<Diagnostic> = Vec::new();
    for error in unfit {
        for new in refusal(error, &plan.graph).into_diagnostics() {
            // Several passes may need the same of one target.
            if !found.iter().any(|known| known.message == new.message) {
                found.push(new);
            }
        }
    }
    if found.is_empty() { Ok(()) } else { Err(BuildError::Diagnosed(found)) }
}

/// An error of the device as a diagnostic that points at a place that the author can change, if there is one.
fn refusal(error: ExecuteError, graph: &Graph) -> BuildError {
    let resource = |name: &str| graph.find_resource(name).map(|id| graph.resource(id).place.clone());
    let pass = |name: &str| graph.find_pass(name).map(|id| graph.pass(id).place.clone());
    let place: Option<(Span, &str)> = match &error {
        ExecuteError::MissingSource { buffer, .. } => resource(buffer).map(|span| (span, "this buffer")),
        ExecuteError::Format { target, .. } => resource(target).map(|span| (span, "this target")),
        ExecuteError::Capability { pass: name, .. } => pass(name).map(|span| (span, "this pass")),
        ExecuteError::Gpu(
            raxel_gpu::Error::OutOfMemory { name, .. }
            | raxel_gpu::Error::TooLarge { name, .. }
            | raxel_gpu::Error::FormatUnsupported { name, .. },
        ) => resource(name).map(|span| (span, "for this")),
        _ => None,
    };
    let Some((span, text)) = place else { return BuildError::Device(error) };
    let diagnostic = Diagnostic::error(codes::session::DEVICE_REFUSES, error.to_string()).label(span, text);
    BuildError::Diagnosed(vec![match &error {
        ExecuteError::Format { .. } => {
            diagnostic.help("choose a format that every device has: `raxel explain RX0410` lists them")
        }
        ExecuteError::Capability { .. } => diagnostic
            .help("write the shader without it, or choose another device: `raxel doctor` lists those of this machine"),
        ExecuteError::Gpu(raxel_gpu::Error::OutOfMemory { .. }) => {
            diagnostic.help("a smaller picture or world needs less memory")
        }
        _ => diagnostic,
    }])
}
