//! The running plan in words: its passes, its resources, its memory. Only another plan changes them.

use std::collections::HashMap;
use std::fmt::Write as _;
use std::sync::Arc;

use raxel_diagnostics::{SourceMap, Span, render};
use raxel_execute::PassOutcome;
use raxel_graph::checked::{BoundAccess, BufferSize, Graph, PassId, Resource, ResourceId, ResourceKind};
use raxel_graph::plan::{CullReason, Lifetime, Plan, ResourceDesc};
use raxel_graph::size::Size;
use raxel_panels::view::{self, PassState, Use};
use raxel_workbench::writes::default_files;

/// A plan in words.
pub(super) struct Described {
    pub(super) plan: Arc<Plan>,
    pub(super) rows: Vec<Row>,
    pub(super) resources: Vec<view::Resource>,
    pub(super) memory: u64,
    pub(super) saved: u64,
    /// The file that the default of each param stands in.
    pub(super) defaults: HashMap<String, String>,
}

/// A pass of the plan's graph, planned or not.
pub(super) struct Row {
    pub(super) pass: PassId,
    pub(super) name: String,
    pub(super) after: String,
    pub(super) groups: String,
    pub(super) place: String,
    pub(super) output: Option<usize>,
    /// Index into the plan's passes, or why it is left out.
    pub(super) planned: Result<usize, CullReason>,
}

impl Described {
    #[expect(clippy::cast_possible_truncation, reason = "a graph numbers its passes in 32 bits")]
    /// In words. `texts` are the files that the graph was read from.
    pub(super) fn new(graph: &Graph, plan: &Arc<Plan>, texts: &SourceMap) -> Described {
        let ids = (0..plan.graph.passes.len() as u32).map(PassId).filter(|id| plan.shows(*id));
        let rows: Vec<Row> = ids.flat_map(|id| rows(graph, plan, id, texts)).collect();
        let resources = (0..graph.resources.len()).map(|index| resource(graph, plan, (index, &rows), texts)).collect();
        let own = |desc: &ResourceDesc| matches!(desc, ResourceDesc::Image(_) | ResourceDesc::Buffer(_));
        let (mut apart, mut shared) = (0, 0);
        for planned in plan.resources.iter().filter(|planned| own(&planned.desc)) {
            let bytes = planned.memory.size * u64::from(planned.copies);
            match planned.lifetime {
                Lifetime::Transient { place: Some(_), .. } => shared += bytes,
                _ => apart += bytes,
            }
        }
        let blocks: u64 = plan.blocks.iter().map(|block| block.size).sum();
        let (memory, saved) = (apart + blocks, shared.saturating_sub(blocks));
        Described { plan: plan.clone(), rows, resources, memory, saved, defaults: default_files(graph, texts) }
    }
}

/// The state of the pass of a row.
pub(super) fn state(row: &Row, outcomes: &[PassOutcome]) -> PassState {
    match row.planned {
        Err(CullReason::Unused) => PassState::Unused,
        Err(CullReason::Condition) => PassState::Condition,
        Ok(index) => match outcomes.get(index) {
            Some(PassOutcome::Skipped) => PassState::Skipped,
            Some(PassOutcome::NotDue) => PassState::NotDue,
            Some(PassOutcome::Off) => PassState::Off,
            Some(PassOutcome::Dispatched) | None => PassState::Ran,
        },
    }
}

/// A row for each tick in which a pass may run, or one row with the reason if it does not run.
fn rows(graph: &Graph, plan: &Plan, id: PassId, texts: &SourceMap) -> Vec<Row> {
    let pass = plan.graph.pass(id);
    let written = accesses(graph, plan, id).find(|(_, access)| access.access.writes());
    let row = |name, groups, planned| Row {
        pass: id,
        name,
        after: pass.name.clone(),
        groups,
        place: place(&pass.place, texts),
        output: written.map(|(resource, _)| resource.0 as usize),
        planned,
    };
    let planned = plan.passes.iter().enumerate().filter(|(_, planned)| planned.pass == id);
    let planned: Vec<Row> = planned
        .map(|(index, planned)| {
            let name = match planned.tick {
                Some(tick @ 1..) => format!("{}, tick {}", pass.name, tick + 1),
                _ => pass.name.clone(),
            };
            let groups =
                planned.groups.map_or_else(|| "as a buffer says".to_owned(), |[x, y, z]| format!("{x} × {y} × {z}"));
            row(name, groups, Ok(index))
        })
        .collect();
    if !planned.is_empty() {
        return planned;
    }
    let reason = plan.culled.iter().find(|culled| culled.pass == id).map_or(CullReason::Unused, |culled| culled.reason);
    vec![row(pass.name.clone(), String::new(), Err(reason))]
}

/// The resources that a pass touches, by the names that its file uses: in a loop, names may stand for each other's memory.
pub(super) fn accesses<'p>(
    graph: &'p Graph,
    plan: &'p Plan,
    id: PassId,
) -> impl Iterator<Item = (ResourceId, &'p BoundAccess)> {
    let declared = &graph.pass(plan.graph.declared(id)).accesses;
    declared.iter().map(|access| access.resource).zip(&plan.graph.pass(id).accesses)
}

fn resource(graph: &Graph, plan: &Plan, (index, rows): (usize, &[Row]), texts: &SourceMap) -> view::Resource {
    let found = &plan.graph.resources[index];
    let planned = plan.resources.iter().find(|planned| planned.resource.0 as usize == index);
    let uses = rows.iter().map(|row| used(accesses(graph, plan, row.pass), index)).collect();
    let (mut bytes, mut memory, mut block) = (0, "not created".to_owned(), None);
    if let Some(planned) = planned {
        bytes = planned.memory.size * u64::from(planned.copies);
        memory = match (&planned.desc, planned.lifetime) {
            (ResourceDesc::Source(name) | ResourceDesc::SourceImage(name, _), _) => format!("supplied by {name}"),
            (_, Lifetime::Persistent) => "own memory, kept from frame to frame".to_owned(),
            (_, Lifetime::Transient { place: Some(place), .. }) => {
                block = Some(place.block);
                format!("in block {} at {}", place.block, place.offset)
            }
            (_, Lifetime::Transient { .. }) => "own memory".to_owned(),
        };
    }
    let world = matches!(&found.kind, ResourceKind::Buffer(buffer) if matches!(buffer.size, BufferSize::Source(_)));
    view::Resource {
        name: found.name.clone(),
        about: about(found, plan.sizes.get(index)),
        bytes,
        memory,
        block,
        place: place(&found.place, texts),
        opaque: world,
        uses,
    }
}

/// How a pass with these accesses touches a resource.
fn used<'p>(accesses: impl Iterator<Item = (ResourceId, &'p BoundAccess)>, resource: usize) -> Use {
    let touched: Vec<&BoundAccess> =
        accesses.filter(|(id, _)| id.0 as usize == resource).map(|(_, access)| access).collect();
    let written = touched.iter().find(|access| access.access.writes());
    let part = written.or(touched.first());
    Use {
        reads: touched.iter().any(|access| access.access.reads()),
        writes: written.is_some(),
        mip: part.map_or(0, |access| access.mips.first),
        layer: part.map_or(0, |access| access.layers.first),
    }
}

/// `rgba16f 1280 × 720, 2 layers`.
pub(super) fn about(resource: &Resource, size: Option<&Size>) -> String {
    let mut text = match (&resource.kind, size) {
        (ResourceKind::Target(target), Some(&Size::Image { extent: [x, y, z], volume, mips, layers })) => {
            let mut text = format!("{} {x} × {y}", target.format.name());
            if volume {
                let _ = write!(text, " × {z}");
            }
            if layers > 1 {
                let _ = write!(text, ", {layers} layers");
            }
            if mips > 1 {
                let _ = write!(text, ", {mips} mips");
            }
            text
        }
        (ResourceKind::Buffer(buffer), Some(&Size::Buffer { bytes, elements })) => {
            match (bytes, buffer.size.stride()) {
                (_, Some(stride)) => format!("buffer, {elements} × {stride} bytes"),
                (Some(bytes), None) => format!("buffer, {bytes} bytes"),
                (None, None) => "buffer".to_owned(),
            }
        }
        _ => String::new(),
    };
    if resource.history > 0 {
        let _ = write!(text, ", history {}", resource.history);
    }
    text
}

/// Path and line.
pub(super) fn place(span: &Span, texts: &SourceMap) -> String {
    match texts.get(&span.file) {
        Some(text) => format!("{}:{}", span.file, render::position(text, span.range.start).line),
        None => span.file.to_string(),
    }
}
