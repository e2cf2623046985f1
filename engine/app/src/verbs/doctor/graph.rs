//! `raxel doctor --graph`: what a graph needs of the device, and whether it runs.

use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use raxel_diagnostics::SourceMap;
use raxel_gpu::{Device, DeviceOptions};
use raxel_graph::checked::Graph;
use raxel_graph::needs;
use raxel_graph::plan::Plan;
use raxel_runtime::debug_target::DebugTarget;
use raxel_runtime::project::Project;
use raxel_runtime::session::{Options, Session};
use raxel_terminal::console::Console;
use raxel_terminal::failure::{Failure, Result};
use raxel_terminal::offline::{Conditions, OfflineProject, Paper};
use raxel_terminal::session::{frame_failure, open_failure};

use super::{Grade, Report, counted};

/// Output size of the picture that is made to see whether the graph runs, in pixels.
const SIZE: [u32; 2] = [320, 180];

/// Says how much of each limit the graph needs, with the pass that needs most, and makes one picture.
pub(super) fn judge(graph: &Path, device: &Arc<Device>, options: &DeviceOptions, report: &mut Report<'_>) -> Result {
    let console = report.console;
    // Mistakes in its files are printed once, and then there is nothing to run.
    let read = Read::of(graph, console)?;
    let (planned, failure) = match run(graph, options, console) {
        Ok((plan, milliseconds)) => {
            let passes = counted(plan.passes.len(), "pass", "passes");
            (plan, Ok(format!("runs: {passes}, the first picture after {milliseconds:.0} ms")))
        }
        // A graph that does not run has needs all the same.
        Err(failure) => (read.on_paper(console)?, Err(failure)),
    };
    for need in needs(&planned, &raxel_execute::limits(device)) {
        let grade = if need.is_met() { Grade::Good } else { Grade::Bad };
        let finding = format!("{} in pass `{}`; the device has {} ({})", need.needs, need.pass, need.has, need.limit);
        report.line(grade, need.what, &finding);
    }
    match failure {
        Ok(finding) => report.line(Grade::Good, "graph", &finding),
        Err(failure) => report.bad("graph", failure),
    }
    Ok(())
}

/// Makes one picture; its plan, and how long it took in milliseconds.
fn run(graph: &Path, options: &DeviceOptions, console: &Console) -> Result<(Arc<Plan>, f64)> {
    let start = Instant::now();
    let options = Options {
        graph: Some(graph.to_owned()),
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
    texts: SourceMap,
}

impl Read {
    fn of(graph: &Path, console: &Console) -> Result<Self> {
        let (offline, path) = OfflineProject::of(Some(graph), Project::default_graph, console)?;
        let part = offline.loader.graph(&path);
        let texts = part.texts.clone();
        let graph = OfflineProject::good(part, console)?;
        Ok(Self { offline, graph, texts })
    }

    /// The plan as it is made without a device.
    fn on_paper(&self, console: &Console) -> Result<Arc<Plan>> {
        let Self { offline, graph, texts } = self;
        let present = DebugTarget::default().resolve(graph).map_err(|error| Failure::usage(error.to_string()))?;
        let over = offline.planned_over(None, graph.is_sized_by_world() || graph.asks_the_world());
        let paper = Paper { output: SIZE, present, over: &over, conditions: Conditions::AtStart };
        paper.plan(graph).map(Arc::new).map_err(|found| console.stop_in(&found, texts))
    }
}
