//! The words of all printers for a plan.

use std::fmt::Write as _;

use crate::ir::checked::{Clock, Condition, Dispatch, Every, Fact, Graph, PassId, ResourceId};
use crate::ir::plan::{
    CullReason, Culled, Dependency, Hazard, HazardKind, PassPlan, Plan, Present, ResourceDesc, ResourcePlan, Scope,
    Step,
};

/// Bytes for people, e.g. `3.5 MiB`.
pub(crate) fn bytes(bytes: u64) -> String {
    const UNITS: [&str; 5] = ["B", "KiB", "MiB", "GiB", "TiB"];
    let unit = (0..UNITS.len() - 1).find(|&unit| bytes >> (10 * unit) < 1024).unwrap_or(UNITS.len() - 1);
    if unit == 0 {
        return format!("{bytes} B");
    }
    let value = bytes as f64 / (1_u64 << (10 * unit)) as f64;
    if value < 100.0 { format!("{value:.1} {}", UNITS[unit]) } else { format!("{value:.0} {}", UNITS[unit]) }
}

/// `word` with its number, e.g. `1 pass`, `2 passes`.
pub(crate) fn counted(count: usize, one: &str, many: &str) -> String {
    format!("{count} {}", if count == 1 { one } else { many })
}

/// The description of a resource, e.g. `rgba16f 1280×720, 4 mips`.
pub(crate) fn describe(desc: &ResourceDesc) -> String {
    match desc {
        ResourceDesc::SourceImage(name, image) if image.extent == [1; 3] => {
            format!("{} from {name}", image.format.name())
        }
        ResourceDesc::SourceImage(name, image) => format!("{} from {name}", describe(&ResourceDesc::Image(*image))),
        ResourceDesc::Image(image) => {
            let [w, h, d] = image.extent;
            let mut text = format!("{} {w}×{h}", image.format.name());
            if image.volume {
                let _ = write!(text, "×{d}");
            }
            if image.mips > 1 {
                let _ = write!(text, ", {} mips", image.mips);
            }
            if image.layers > 1 {
                let _ = write!(text, ", {} layers", image.layers);
            }
            text
        }
        ResourceDesc::Buffer(buffer) => format!("buffer, {}", bytes(buffer.size)),
        ResourceDesc::Source(name) => format!("from {name}"),
    }
}

/// Name of a resource of the plan.
pub(crate) fn resource_name(plan: &Plan, index: u32) -> &str {
    name_of(&plan.graph, plan.resources[index as usize].resource)
}

/// Name of a resource of the graph.
pub(crate) fn name_of(graph: &Graph, id: ResourceId) -> &str {
    &graph.resource(id).name
}

/// Name of a resource at an age, e.g. `color@1`.
pub(crate) fn aged(graph: &Graph, id: ResourceId, age: u32) -> String {
    let name = name_of(graph, id);
    if age == 0 { name.to_owned() } else { format!("{name}@{age}") }
}

/// The debug target, e.g. `pyramid, mip 2, after blur`.
pub(crate) fn present(graph: &Graph, present: Present) -> String {
    let mut text = aged(graph, present.resource, present.age);
    if present.mip > 0 {
        let _ = write!(text, ", mip {}", present.mip);
    }
    if present.layer > 0 {
        let _ = write!(text, ", layer {}", present.layer);
    }
    if let Some(pass) = present.after {
        let _ = write!(text, ", after {}", graph.pass(pass).name);
    }
    text
}

/// The name of a hazard, e.g. `read after write`.
pub(crate) fn kind(kind: HazardKind) -> &'static str {
    match kind {
        HazardKind::ReadAfterWrite => "read after write",
        HazardKind::WriteAfterRead => "write after read",
        HazardKind::WriteAfterWrite => "write after write",
        HazardKind::Alias => "takes over memory",
    }
}

/// A hazard of the barrier at a step in a line, e.g. `hit: read after write, primary → shade`.
pub(crate) fn hazard(plan: &Plan, at: usize, hazard: &Hazard) -> String {
    let graph = &plan.graph;
    let from = actor(graph, hazard.from, hazard.kind == HazardKind::WriteAfterRead);
    let to = actor(graph, hazard.to, hazard.kind == HazardKind::ReadAfterWrite);
    // A barrier behind the later access's place in the frame is about that access in the next one.
    let ends_here = plan.steps[at..].iter().any(|step| match (step, hazard.to) {
        (Step::Dispatch { pass }, Some(to)) => plan.passes[*pass as usize].pass == to,
        (Step::Clear { resource, .. } | Step::Copy { resource }, None) => {
            plan.resources[*resource as usize].resource == hazard.resource
        }
        (Step::Present, None) => hazard.kind == HazardKind::ReadAfterWrite,
        _ => false,
    });
    let (of_from, of_to) = match (hazard.wraps, ends_here) {
        (false, _) => ("", ""),
        (true, true) => (" of an earlier frame", ""),
        (true, false) => ("", " of the next frame"),
    };
    format!("{}: {}, {from}{of_from} → {to}{of_to}", name_of(graph, hazard.resource), kind(hazard.kind))
}

fn actor(graph: &Graph, pass: Option<PassId>, reads: bool) -> &str {
    match pass {
        Some(pass) => &graph.pass(pass).name,
        None if reads => "present",
        None => "clear",
    }
}

/// Scopes of a dependency in a line.
pub(crate) fn dependency(dependency: &Dependency) -> String {
    format!("{} → {}", scope(dependency.src), scope(dependency.dst))
}

fn scope(scope: Scope) -> String {
    if scope.access.is_empty() { scope.stages.to_string() } else { format!("{} ({})", scope.stages, scope.access) }
}

/// Why a pass is left out.
pub(crate) fn culled(graph: &Graph, culled: &Culled) -> String {
    match (culled.reason, conditions(graph, &graph.pass(culled.pass).when)) {
        (CullReason::Condition, Some(when)) => format!("`when = \"{when}\"` does not hold"),
        (CullReason::Condition, None) => "its condition does not hold".to_owned(),
        (CullReason::Unused, _) => "nothing presented depends on it".to_owned(),
    }
}

/// The conditions under which a pass runs; `None` where nothing must.
pub(crate) fn conditions(graph: &Graph, all: &[Condition]) -> Option<String> {
    let words: Vec<String> = all.iter().map(|one| condition(graph, one)).collect();
    (!words.is_empty()).then(|| words.join(" and "))
}

/// A condition as the file writes it.
fn condition(graph: &Graph, condition: &Condition) -> String {
    let fact = match &condition.fact {
        Fact::WorldHasEmission => "world.has_emission".to_owned(),
        Fact::WorldHasTransparency => "world.has_transparency".to_owned(),
        Fact::WorldHasVoxels => "world.has_voxels".to_owned(),
        Fact::WorldHasInstances => "world.has_instances".to_owned(),
        Fact::DevicePackets => "device.packets".to_owned(),
        Fact::DeviceBallots => "device.ballots".to_owned(),
        Fact::Param(id) => format!("param.{}", graph.params[id.0 as usize].name),
    };
    format!("{}{fact}", if condition.negated { "!" } else { "" })
}

/// A clock, e.g. `sim, 60 ticks a second, at most 4 in a frame`.
pub(crate) fn clock(clock: &Clock) -> String {
    let Clock { name, hz, most, .. } = clock;
    format!("{name}, {hz} ticks a second, at most {most} in a frame")
}

/// When a pass runs, if not in every frame.
pub(crate) fn every(graph: &Graph, every: Every) -> String {
    match every {
        Every::Hz(hz) => format!("{hz} times a second"),
        Every::Frames(frames) => format!("every {frames} frames"),
        Every::Still(frames) => format!("until all is still for {}", counted(frames as usize, "frame", "frames")),
        Every::Clock(clock) => format!("by clock {}", graph.clock(clock).name),
    }
}

/// How much a pass dispatches, e.g. `160×90×1 groups`.
pub(crate) fn work(plan: &Plan, pass: u32) -> String {
    let pass = &plan.passes[pass as usize];
    match (pass.groups, &plan.graph.pass(pass.pass).dispatch) {
        (Some([x, y, z]), _) => format!("{x}×{y}×{z} groups"),
        (None, Dispatch::Indirect { buffer, .. }) if plan.graph.resource(*buffer).made => {
            let queue = plan.graph.queue_of(*buffer);
            let (name, offset) = queue.map_or(("a queue", 0), |(queue, at)| (name_of(&plan.graph, queue), at));
            if offset == 0 { format!("threads from {name}") } else { format!("threads from {name} + {offset}") }
        }
        (None, Dispatch::Indirect { buffer, offset }) => {
            let name = name_of(&plan.graph, *buffer);
            if *offset == 0 { format!("groups from {name}") } else { format!("groups from {name} + {offset}") }
        }
        (None, _) => "groups from a buffer".to_owned(),
    }
}

/// Names that a pass loads and stores, each once.
pub(crate) fn loads_and_stores(graph: &Graph, pass: PassId) -> (Vec<String>, Vec<String>) {
    let (mut loads, mut stores) = (Vec::new(), Vec::new());
    for access in &graph.pass(pass).accesses {
        let name = aged(graph, access.resource, access.age);
        for (list, does) in [(&mut loads, access.access.reads()), (&mut stores, access.access.writes())] {
            if does && !list.contains(&name) {
                list.push(name.clone());
            }
        }
    }
    (loads, stores)
}

/// Bytes of all copies of a resource.
pub(crate) fn all_copies(resource: &ResourcePlan) -> u64 {
    resource.memory.size.saturating_mul(resource.copies.into())
}

/// Memory of a plan.
pub(crate) struct Memory {
    /// Bytes that are allocated; sources are the runtime's.
    pub allocated: u64,
    /// Bytes that resources in shared blocks would take apart from each other, less the blocks.
    pub saved: u64,
}

/// Counts the memory of a plan.
pub(crate) fn memory(plan: &Plan) -> Memory {
    let (mut own, mut placed) = (0_u64, 0_u64);
    for resource in &plan.resources {
        match &resource.desc {
            ResourceDesc::Source(_) | ResourceDesc::SourceImage(..) => {}
            _ if block_of(resource).is_some() => placed = placed.saturating_add(all_copies(resource)),
            _ => own = own.saturating_add(all_copies(resource)),
        }
    }
    let blocks = plan.blocks.iter().fold(0_u64, |sum, block| sum.saturating_add(block.size));
    Memory { allocated: own.saturating_add(blocks), saved: placed.saturating_sub(blocks) }
}

/// Block and offset of a resource that shares memory.
pub(crate) fn block_of(resource: &ResourcePlan) -> Option<(u32, u64)> {
    match resource.lifetime {
        crate::ir::plan::Lifetime::Transient { place: Some(place), .. } => Some((place.block, place.offset)),
        _ => None,
    }
}

/// The passes that a plan runs with their numbers, those of a clock once.
pub(crate) fn each_pass(plan: &Plan) -> impl Iterator<Item = (usize, &PassPlan)> {
    plan.passes.iter().enumerate().filter(|(_, pass)| pass.tick.unwrap_or(0) == 0)
}

/// The suffix of the name of a step that runs once for each tick, e.g. ` (tick 2)`.
pub(crate) fn tick(tick: Option<u32>) -> String {
    tick.map_or_else(String::new, |tick| format!(" (tick {tick})"))
}

/// A barrier in a picture of a plan.
pub(crate) struct DrawnBarrier {
    /// The purpose, a line each.
    pub label: String,
    /// Ends of the arrows that lead to it and away from it: passes (`p0`) and other barriers (`b0`). Barriers are numbered in their order.
    pub arrows: Vec<(String, String)>,
}

/// Every barrier, between the passes that it keeps apart.
pub(crate) fn drawn_barriers(plan: &Plan) -> Vec<DrawnBarrier> {
    let mut drawn_barriers: Vec<DrawnBarrier> = Vec::new();
    // The steps since the barrier before.
    let mut since: Vec<String> = Vec::new();
    for (at, step) in plan.steps.iter().enumerate() {
        match step {
            Step::Dispatch { pass } => {
                let name = format!("p{}", plan.passes[*pass as usize].pass.0);
                if let Some(number) = drawn_barriers.len().checked_sub(1) {
                    drawn_barriers[number].arrow(format!("b{number}"), name.clone());
                }
                since.push(name);
            }
            Step::Barrier(barrier) => {
                let hazards = barrier.hazards.iter().map(|of| hazard(plan, at, of));
                let activated =
                    barrier.activate.iter().map(|of| format!("activate {}", resource_name(plan, of.resource)));
                let label = std::iter::once("barrier".to_owned())
                    .chain(hazards)
                    .chain(activated)
                    .collect::<Vec<_>>()
                    .join("\n");
                let mut drawn = DrawnBarrier { label, arrows: Vec::new() };
                let number = drawn_barriers.len();
                if since.is_empty() && number > 0 {
                    since.push(format!("b{}", number - 1));
                }
                since.drain(..).for_each(|from| drawn.arrow(from, format!("b{number}")));
                drawn_barriers.push(drawn);
            }
            Step::Clear { .. } | Step::Copy { .. } | Step::Present => {}
        }
    }
    drawn_barriers
}

impl DrawnBarrier {
    /// Adds an arrow, unless it is there: a pass of a loop has many rounds.
    fn arrow(&mut self, from: String, to: String) {
        if !self.arrows.iter().any(|arrow| *arrow == (from.clone(), to.clone())) {
            self.arrows.push((from, to));
        }
    }
}

/// Number of barriers in a plan.
pub(crate) fn barriers(plan: &Plan) -> usize {
    plan.steps.iter().filter(|step| matches!(step, Step::Barrier(_))).count()
}
