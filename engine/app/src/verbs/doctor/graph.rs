//! `raxel doctor --graph`: what a graph needs of the device, and whether it runs.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use raxel_gpu::{Device, DeviceOptions};
use raxel_graph::checked::Graph;
use raxel_graph::needs;
use raxel_graph::plan::{Plan, ResourceDesc};
use raxel_graph::print::allocated;
use raxel_runtime::debug_target::DebugTarget;
use raxel_runtime::project::Project;
use raxel_runtime::session::{Options, Session};
use raxel_runtime::world::SessionWorld;
use raxel_terminal::console::Console;
use raxel_terminal::failure::{Failure, Result};
use raxel_terminal::offline::{Conditions, OfflineProject, Paper};
use raxel_terminal::session::{frame_failure, open_failure};

use super::{Grade, Report, counted};
use crate::verbs::world::bytes;

/// Output size of the picture that is made to see whether the graph runs, in pixels.
const SIZE: [u32; 2] = [320, 180];

/// Says how much of each limit the graph needs, with the pass that needs most, and which features, formats and subgroups it uses. Then it makes one
/// picture over the world.
pub(super) fn judge(
    (graph, world): (&Path, Option<&Path>),
    device: &Arc<Device>,
    options: &DeviceOptions,
    report: &mut Report<'_>,
) -> Result {
    let console = report.console;
    // Mistakes in its files are printed once, and then there is nothing to run.
    let read = Read::of((graph, world), console)?;
    let (planned, failure) = match run((graph, world), options, console) {
        Ok((plan, milliseconds)) => {
            let passes = counted(plan.passes.len(), "pass", "passes");
            (plan, Ok(format!("runs: {passes}, the first picture after {milliseconds:.0} ms")))
        }
        // A graph that does not run has needs all the same, unless its errors keep it from a plan: they are printed already.
        Err(failure) => {
            let Some(plan) = read.on_paper() else {
                report.bad("graph", failure);
                return Ok(());
            };
            (plan, Err(failure))
        }
    };
    for need in needs(&planned, &raxel_execute::limits(device.capabilities())) {
        let grade = if need.is_met() { Grade::Good } else { Grade::Bad };
        let finding = format!("{} in pass `{}`; the device has {} ({})", need.needs, need.pass, need.has, need.limit);
        report.line(grade, need.what, &finding);
    }
    for used in raxel_execute::uses(device, &planned)? {
        let (grade, has) = if used.has { (Grade::Good, "has") } else { (Grade::Bad, "lacks") };
        report.line(grade, used.kind, &format!("`{}` in {}; the device {has} it", used.name, used.by));
    }
    subgroups(&planned, device, report);
    memory(&planned, device, report);
    match failure {
        Ok(finding) => report.line(Grade::Good, "graph", &finding),
        Err(failure) => report.bad("graph", failure),
    }
    Ok(())
}

/// The sizes of subgroups that passes ask for.
fn subgroups(plan: &Plan, device: &Device, report: &Report<'_>) {
    let able = device.capabilities();
    let mut asked: BTreeMap<u32, &str> = BTreeMap::new();
    for pass in plan.passes.iter().map(|planned| plan.graph.pass(planned.pass)) {
        if let Some(size) = pass.subgroup_size {
            asked.entry(size).or_insert(&pass.name);
        }
    }
    for (size, pass) in asked {
        let (grade, has) = if able.asks_for_subgroups_of(size) || able.subgroup_size == size {
            (Grade::Good, "the device has it".to_owned())
        } else {
            (Grade::Optional, format!("the device runs the pass with its own size, {}", able.subgroup_size))
        };
        report.line(grade, "subgroup size", &format!("{size} in pass `{pass}`; {has}"));
    }
}

/// The memory that the graph takes at this output size, and each part of the world that it binds.
fn memory(plan: &Plan, device: &Device, report: &Report<'_>) {
    let able = device.capabilities();
    let range = u64::from(able.limits.max_storage_buffer_range);
    let mut all = allocated(plan);
    let [x, y] = plan.output;
    let own = format!("{} for its targets and buffers at {x}×{y}", bytes(all));
    for planned in &plan.resources {
        let (ResourceDesc::Source(name) | ResourceDesc::SourceImage(name, _)) = &planned.desc else { continue };
        let taken = planned.memory.size;
        // Of a plan without a device nobody knows it.
        if taken == 0 {
            continue;
        }
        all += taken;
        let limit = match planned.desc {
            ResourceDesc::Source(_) => format!("; the device has {} (maxStorageBufferRange)", bytes(range)),
            _ => String::new(),
        };
        report.line(Grade::Good, "source", &format!("{} for `{name}`{limit}", bytes(taken)));
    }
    let grade = if all <= able.memory { Grade::Good } else { Grade::Optional };
    let finding = format!("{own}, {} with its sources; the device has {}", bytes(all), bytes(able.memory));
    report.line(grade, "memory", &finding);
}

/// Makes one picture; its plan, and how long it took in milliseconds.
fn run((graph, world): (&Path, Option<&Path>), options: &DeviceOptions, console: &Console) -> Result<(Arc<Plan>, f64)> {
    let start = Instant::now();
    let options = Options {
        graph: Some(graph.to_owned()),
        world: world.map(Path::to_owned),
        size: SIZE,
        device: options.device.clone(),
        validation: options.validation,
        ..Options::default()
    };
    let mut session = Session::open(options).map_err(|error| open_failure(error, console))?;
    session.frame().map_err(|error| frame_failure(error, console))?;
    session.wait().map_err(|error| frame_failure(error, console))?;
    let milliseconds = start.elapsed().as_secs_f64() * 1e3;
    let plan = session.plan().cloned().ok_or_else(|| Failure::usage("the graph has no plan"))?;
    Ok((plan, milliseconds))
}

/// A graph whose files are right.
struct Read {
    offline: OfflineProject,
    graph: Arc<Graph>,
    world: Option<Arc<SessionWorld>>,
}

impl Read {
    fn of((graph, world): (&Path, Option<&Path>), console: &Console) -> Result<Self> {
        let (offline, path) = OfflineProject::of(Some(graph), Project::default_graph, console)?;
        let part = offline.loader.graph(&path);
        let graph = OfflineProject::good(part, console)?;
        let world = world.map(|world| offline.named_world(world, console)).transpose()?;
        Ok(Self { offline, graph, world })
    }

    /// The plan as it is made without a device.
    fn on_paper(&self) -> Option<Arc<Plan>> {
        let Self { offline, graph, world } = self;
        let present = DebugTarget::default().resolve(graph).ok()?;
        let over = offline.planned_over(world.clone(), graph.is_sized_by_world() || graph.asks_the_world());
        let paper = Paper { output: SIZE, present, over: &over, conditions: Conditions::AtStart };
        paper.plan(graph).map(Arc::new).ok()
    }
}
