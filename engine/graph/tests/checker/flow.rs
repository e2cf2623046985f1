//! Is the right thing done, in the right order? The judge of culling pushes the names of passes forward through many frames. If a name
//! reaches the picture or a pin, its pass must run.

use std::collections::{BTreeMap, BTreeSet};

use raxel_graph::checked::*;
use raxel_graph::plan::{CullReason, Observe, Plan, Step};

use super::graphs::{Case, OUTPUT, SOURCE_IMAGE, random};
use super::sizes::of_world;

/// Mips and layers of every resource.
pub(crate) fn subresources(graph: &Graph) -> Vec<(u32, u32)> {
    graph
        .resources
        .iter()
        .map(|resource| match &resource.kind {
            ResourceKind::Buffer(_) => (1, 1),
            ResourceKind::Target(target) => {
                // Random graphs have no `of`.
                let longest = match target.extent {
                    Extent::Output { scale } => (0..2).map(|i| (f64::from(OUTPUT[i]) * scale[i]).round() as u32).max(),
                    Extent::Fixed2(axes) => axes.into_iter().max(),
                    Extent::Fixed3(axes) => axes.into_iter().max(),
                    Extent::Source => SOURCE_IMAGE.into_iter().max(),
                    Extent::World { scale } => of_world(scale).into_iter().max(),
                    Extent::Of { .. } => None,
                };
                let mut chain = 1;
                while longest.unwrap_or(1) >> chain > 0 {
                    chain += 1;
                }
                (if target.mips == 0 { chain } else { target.mips }, target.layers)
            }
        })
        .collect()
}

/// Every (mip, layer) that an access touches.
pub(crate) fn touched(access: &BoundAccess, (mips, layers): (u32, u32)) -> Vec<(u32, u32)> {
    let inside = |part: Interval, at: u32| (part.first..part.end()).contains(&at);
    let mut all = Vec::new();
    for mip in (0..mips).filter(|&mip| inside(access.mips, mip)) {
        all.extend((0..layers).filter(|&layer| inside(access.layers, layer)).map(|layer| (mip, layer)));
    }
    all
}

fn cleared(kind: &ResourceKind) -> bool {
    match kind {
        ResourceKind::Target(target) => target.clear.is_some(),
        ResourceKind::Buffer(buffer) => buffer.clear.is_some(),
    }
}

/// Ranges of passes (of the file) that run together: those of a clock, and every other one alone.
pub(crate) fn groups(graph: &Graph) -> Vec<(std::ops::Range<usize>, Option<ClockId>)> {
    let mut groups: Vec<(std::ops::Range<usize>, Option<ClockId>)> = Vec::new();
    for (index, pass) in graph.passes.iter().enumerate() {
        let clock = if let Some(Every::Clock(clock)) = pass.every { Some(clock) } else { None };
        match groups.last_mut() {
            Some((range, of)) if clock.is_some() && *of == clock => range.end = index + 1,
            _ => groups.push((index..index + 1, clock)),
        }
    }
    groups
}

/// The contents of everything while frames go by: (resource, copy, mip, layer) → passes whose stores are in there, directly or through
/// what they stored into others.
struct Flow<'a> {
    case: &'a Case,
    sizes: Vec<(u32, u32)>,
    live: u64,
    contents: BTreeMap<(u32, u32, u32, u32), u64>,
    looked_at: BTreeSet<(u32, u32, u32)>,
    /// Parts that hold nothing of the frames before this one.
    anew: BTreeSet<(u32, u32, u32)>,
    needed: u64,
    frame: u32,
    /// By clock: ticks begun, many from the start.
    ticks: Vec<u32>,
}

impl<'a> Flow<'a> {
    fn new(case: &'a Case, live: u64) -> Self {
        Flow {
            case,
            sizes: subresources(&case.graph),
            live,
            contents: BTreeMap::new(),
            looked_at: BTreeSet::new(),
            anew: BTreeSet::new(),
            needed: 0,
            frame: 0,
            ticks: vec![1000; case.graph.clocks.len()],
        }
    }

    fn copy(&self, id: ResourceId, age: u32) -> u32 {
        let resource = self.case.graph.resource(id);
        let turns = resource.clock.map_or(self.frame + 1000, |clock| self.ticks[clock.0 as usize]);
        (turns - age) % (resource.history + 1)
    }

    fn read(&self, id: ResourceId, age: u32, parts: &[(u32, u32)]) -> u64 {
        let copy = self.copy(id, age);
        let of = |&(mip, layer): &(u32, u32)| self.contents.get(&(id.0, copy, mip, layer)).copied().unwrap_or(0);
        parts.iter().map(of).fold(0, |all, one| all | one)
    }

    fn run(&mut self, index: usize) {
        let graph = self.case.graph.clone();
        let pass = &graph.passes[index];
        if !self.case.runs(pass) {
            return;
        }
        let mut stored = 1 << index;
        let lives = self.live >> index & 1 == 1;
        for access in pass.accesses.iter().filter(|a| a.access.reads()) {
            let parts = touched(access, self.sizes[access.resource.0 as usize]);
            if lives && access.age == 0 {
                self.looked_at.extend(parts.iter().map(|&(mip, layer)| (access.resource.0, mip, layer)));
            }
            stored |= self.read(access.resource, access.age, &parts);
        }
        for access in pass.accesses.iter().filter(|a| a.access.writes()) {
            for (mip, layer) in touched(access, self.sizes[access.resource.0 as usize]) {
                let at = (access.resource.0, self.copy(access.resource, access.age), mip, layer);
                let cleared = cleared(&graph.resource(access.resource).kind);
                let first = lives && self.looked_at.insert((access.resource.0, mip, layer));
                if first && !cleared && pass.every.is_none() {
                    self.contents.remove(&at);
                    self.anew.insert((access.resource.0, mip, layer));
                }
                *self.contents.entry(at).or_default() |= stored;
            }
        }
    }

    fn present(&mut self) {
        let shown = self.case.present;
        let volume = matches!(
            self.case.graph.resource(shown.resource).kind,
            ResourceKind::Target(Target { extent: Extent::Fixed3(_) | Extent::World { .. } | Extent::Source, .. })
        );
        let part = (shown.mip, if volume { 0 } else { shown.layer });
        if shown.age == 0 {
            self.looked_at.insert((shown.resource.0, part.0, part.1));
        }
        self.needed |= self.read(shown.resource, shown.age, &[part]);
    }
}

/// Parts (resource, mip, layer) that passes touch and that carry contents over. In a frame of the whole graph, without culling, they
/// still hold contents of the frame before, or of a pass that stores only now and then. The shown and pinned resources do not matter
/// here.
pub(crate) fn carried(case: &Case) -> BTreeSet<(u32, u32, u32)> {
    let graph = &case.graph;
    let mut flow = Flow::new(case, u64::MAX);
    let mut touched_by_any = BTreeSet::new();
    let mut now_and_then = BTreeSet::new();
    for (index, pass) in graph.passes.iter().enumerate().filter(|(_, pass)| case.runs(pass)) {
        flow.run(index);
        for access in pass.accesses.iter().filter(|access| access.age == 0) {
            for (mip, layer) in touched(access, flow.sizes[access.resource.0 as usize]) {
                touched_by_any.insert((access.resource.0, mip, layer));
                if pass.every.is_some() && access.access.writes() {
                    now_and_then.insert((access.resource.0, mip, layer));
                }
            }
        }
    }
    touched_by_any.retain(|part| {
        let resource = &graph.resources[part.0 as usize];
        let init = match &resource.kind {
            ResourceKind::Target(target) => target.init.is_some(),
            ResourceKind::Buffer(buffer) => buffer.init.is_some(),
        };
        let supplied = resource.kind.supplied_by().is_some();
        let kept = resource.keep || resource.history > 0 || resource.clock.is_some() || init || supplied;
        let left = !cleared(&resource.kind) && !flow.anew.contains(part);
        kept || left || now_and_then.contains(part)
    });
    touched_by_any
}

/// Passes whose stores can reach the present step, a pin or something that is carried in some frame, as a bit set; `live` is what the plan
/// says. Of all stores, only a clear for the frame and the first access of a frame, if it is write-only and made in each frame, drop what was
/// there.
fn needed(case: &Case, live: u64) -> u64 {
    let graph = &case.graph;
    let carried = carried(case);
    let mut flow = Flow::new(case, live);
    let groups = groups(graph);
    let mut random = random(live);
    for frame in 0..(graph.passes.len() as u32 + 2) * 3 {
        flow.frame = frame;
        flow.looked_at.clear();
        for (index, resource) in graph.resources.iter().enumerate() {
            // A frame without a tick clears nothing that turns with a clock.
            if cleared(&resource.kind) && resource.clock.is_none() {
                let id = ResourceId(index as u32);
                let copy = flow.copy(id, 0);
                flow.contents.retain(|at, _| (at.0, at.1) != (id.0, copy));
            }
        }
        for (passes, clock) in &groups {
            let ticks = clock.map_or(1, |clock| random.below(graph.clock(clock).most + 1));
            for _ in 0..ticks {
                if let Some(clock) = clock {
                    flow.ticks[clock.0 as usize] += 1;
                }
                passes.clone().for_each(|pass| flow.run(pass));
            }
            if case.present.after.is_some_and(|after| passes.contains(&(after.0 as usize))) {
                flow.present();
            }
        }
        if case.present.after.is_none() {
            flow.present();
        }
        for &(resource, mip, layer) in &carried {
            flow.needed |= flow.read(ResourceId(resource), 0, &[(mip, layer)]);
        }
        let all: Vec<ResourceId> = (0..graph.resources.len() as u32).map(ResourceId).collect();
        for pin in if case.observe == Observe::Everything { &all } else { &case.pinned } {
            let (mips, layers) = flow.sizes[pin.0 as usize];
            for mip in 0..mips {
                let parts: Vec<_> = (0..layers).map(|layer| (mip, layer)).collect();
                flow.needed |= flow.read(*pin, 0, &parts);
            }
        }
    }
    flow.needed
}

/// Faults in the choice and order of the steps.
pub(crate) fn faults(case: &Case, plan: &Plan) -> Vec<String> {
    let graph = &case.graph;
    let mut faults = Vec::new();
    let live = plan.passes.iter().fold(0_u64, |set, pass| set | 1 << pass.pass.0);
    let needed = needed(case, live);
    for (index, pass) in graph.passes.iter().enumerate() {
        let id = PassId(index as u32);
        let lives = plan.passes.iter().any(|p| p.pass == id);
        let reason = plan.culled.iter().find(|c| c.pass == id).map(|c| c.reason);
        let expected = match (case.runs(pass), needed >> index & 1 == 1) {
            (false, _) => Some(CullReason::Condition),
            (true, false) => Some(CullReason::Unused),
            (true, true) => None,
        };
        if reason != expected || lives != expected.is_none() {
            faults.push(format!("{}: culled {reason:?}, should be {expected:?}", pass.name));
        }
    }

    // Passes in the order of the file, those of a clock once for each tick.
    let mut expected = Vec::new();
    let groups = groups(graph);
    for (passes, clock) in &groups {
        let live = || passes.clone().filter(|pass| live >> pass & 1 == 1).map(|pass| PassId(pass as u32));
        match clock {
            Some(clock) => {
                expected
                    .extend((0..graph.clock(*clock).most).flat_map(|tick| live().map(move |pass| (pass, Some(tick)))));
            }
            None => expected.extend(live().map(|pass| (pass, None))),
        }
    }
    let mut dispatched = Vec::new();
    let mut presents = 0;
    let mut clears: BTreeMap<(u32, Option<u32>), usize> = BTreeMap::new();
    let mut touched_at: BTreeMap<(u32, Option<u32>), usize> = BTreeMap::new();
    for (at, step) in plan.steps.iter().enumerate() {
        let mut touch = |id: ResourceId, age: u32, by: Option<(ClockId, u32)>| {
            // A resource that turns with a clock is cleared for each tick; outside the clock it is only looked at.
            let tick = match (graph.resource(id).clock, by) {
                (None, _) => None,
                (Some(clock), Some((of, tick))) if clock == of => Some(tick),
                (Some(_), _) => return,
            };
            if age == 0 {
                touched_at.entry((id.0, tick)).or_insert(at);
            }
        };
        match step {
            Step::Barrier(_) => {
                if matches!(plan.steps.get(at + 1), None | Some(Step::Barrier(_))) {
                    faults.push(format!("step {at}: a barrier before nothing"));
                }
            }
            Step::Copy { resource } => {
                if clears.insert((plan.resources[*resource as usize].resource.0, None), at).is_some() {
                    faults.push(format!("step {at}: filled twice"));
                }
                if plan.resources[*resource as usize].copy.is_none() {
                    faults.push(format!("step {at}: not a copy"));
                }
            }
            Step::Clear { resource, tick } => {
                if clears.insert((plan.resources[*resource as usize].resource.0, *tick), at).is_some() {
                    faults.push(format!("step {at}: cleared twice"));
                }
            }
            Step::Dispatch { pass } => {
                let planned = &plan.passes[*pass as usize];
                dispatched.push((planned.pass, planned.tick));
                let of = &graph.pass(planned.pass);
                let by = if let Some(Every::Clock(clock)) = of.every { planned.tick.map(|t| (clock, t)) } else { None };
                for access in &of.accesses {
                    touch(access.resource, access.age, by);
                }
            }
            Step::Present => {
                presents += 1;
                touch(plan.present.resource, plan.present.age, None);
                // After a pass of a clock means after its ticks.
                let of = |after: PassId| groups.iter().find(|(passes, _)| passes.contains(&(after.0 as usize)));
                let last = case.present.after.map_or(PassId(u32::MAX), |after| {
                    of(after).map_or(after, |(passes, _)| PassId(passes.end as u32 - 1))
                });
                if expected.iter().filter(|(pass, _)| *pass <= last).count() != dispatched.len() {
                    faults.push(format!("step {at}: presented at the wrong point"));
                }
            }
        }
    }
    if presents != 1 {
        faults.push(format!("presented {presents} times"));
    }
    if dispatched != expected {
        faults.push(format!("dispatched {dispatched:?}, not {expected:?}"));
    }
    for resource in &plan.resources {
        let id = resource.resource;
        let of = graph.resource(id);
        let transient = resource.lifetime != raxel_graph::plan::Lifetime::Persistent;
        let asked = cleared(&of.kind) || of.origin == Origin::Copy || case.poison && transient;
        let ticks: Vec<Option<u32>> = match of.clock {
            Some(clock) if graph.passes.iter().any(|pass| pass.every == Some(Every::Clock(clock))) => {
                (0..graph.clock(clock).most).map(Some).collect()
            }
            Some(_) => Vec::new(),
            None => vec![None],
        };
        if clears.keys().filter(|(of, _)| *of == id.0).count() != if asked { ticks.len() } else { 0 } {
            faults.push(format!("{}: clears missing or not asked for", of.name));
        }
        for tick in ticks.iter().filter(|_| asked) {
            match (clears.get(&(id.0, *tick)), touched_at.get(&(id.0, *tick))) {
                (None, _) => faults.push(format!("{}: not cleared, {tick:?}", of.name)),
                (Some(clear), Some(touch)) if clear > touch => {
                    faults.push(format!("{}: touched before its clear", of.name));
                }
                _ => {}
            }
        }
    }
    for (index, resource) in graph.resources.iter().enumerate() {
        let id = ResourceId(index as u32);
        let mut accesses = plan.passes.iter().flat_map(|pass| &graph.pass(pass.pass).accesses);
        let asked = id == case.present.resource || case.pinned.contains(&id) || accesses.any(|a| a.resource == id);
        // A clear of a resource that turns serves the frames that look back at it.
        let turns = resource.history > 0 || resource.clock.is_some();
        let watched = case.observe == Observe::Everything || cleared(&resource.kind) && turns;
        let watched = watched && resource.kind.supplied_by().is_none() && fits(graph, id);
        if plan.resources.iter().any(|planned| planned.resource == id) != (asked || watched) {
            faults.push(format!("{}: created, or not, without a reason", resource.name));
        }
    }
    for (clock, of) in graph.clocks.iter().zip(&plan.clocks) {
        let id = ClockId(graph.clocks.iter().position(|other| std::ptr::eq(other, clock)).unwrap_or(0) as u32);
        let in_tick = |step: &Step| match step {
            Step::Dispatch { pass } => {
                let planned = &plan.passes[*pass as usize];
                planned.tick.is_some() && graph.pass(planned.pass).every == Some(Every::Clock(id))
            }
            Step::Clear { resource, tick } => {
                tick.is_some() && graph.resource(plan.resources[*resource as usize].resource).clock == Some(id)
            }
            Step::Barrier(_) | Step::Copy { .. } | Step::Present => false,
        };
        for at in (0..plan.steps.len()).filter(|at| in_tick(&plan.steps[*at])) {
            if !(of.first as usize..of.end as usize).contains(&at) {
                faults.push(format!("step {at} is of the clock {}, which has {of:?}", clock.name));
            }
        }
    }
    faults
}

/// Whether a target is large enough for its mips.
fn fits(graph: &Graph, id: ResourceId) -> bool {
    let ResourceKind::Target(target) = &graph.resource(id).kind else { return true };
    let mut open = graph.clone();
    if let ResourceKind::Target(target) = &mut open.resources[id.0 as usize].kind {
        target.mips = 0;
    }
    target.mips <= subresources(&open)[id.0 as usize].0
}
