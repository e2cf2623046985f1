//! Is every access ordered against every conflicting one?
//!
//! A run unrolls frames and walks them like a queue, remembering every access that was ever made. Each barrier updates, for every
//! remembered access, the stages that now wait for it and, for a store, the accesses that see it (the rules of Vulkan's chapter
//! "Synchronization and Cache Control"; a layout transition is a store by the barrier itself). Each new access asks every remembered one
//! that it conflicts with.

use std::collections::BTreeMap;

use raxel_graph::checked::*;
use raxel_graph::plan::*;
use raxel_shader::interface::Access;

use super::flow::{subresources, touched};
use super::graphs::random;
use super::memory::share;

/// How a plan is run.
pub(crate) struct Run {
    /// Frames that are run.
    pub frames: u32,
    /// The number of first frames whose accesses are remembered. A plan repeats, so one frame shows as much as all.
    pub remembered: u32,
    /// (frame, live pass) that is left out.
    pub skip: Box<dyn Fn(u32, u32) -> bool>,
    /// Ticks that are due: of a frame, of a clock. At most as many as the clock catches up.
    pub ticks: Ticks,
    /// Frames in which the runtime writes all of every source.
    pub updates: fn(u32) -> bool,
    /// `bufferImageGranularity`.
    pub granularity: u64,
}

pub(crate) type Ticks = Box<dyn Fn(u32, ClockId) -> u32>;

impl Run {
    /// All of several rounds through the longest ring of copies.
    pub(crate) fn full(plan: &Plan, granularity: u64) -> Run {
        let ring = plan.resources.iter().map(|r| r.copies).max().unwrap_or(1);
        Run {
            frames: 2 * ring + 2,
            remembered: u32::MAX,
            skip: Box::new(|_, _| false),
            ticks: all_ticks(plan),
            updates: |_| false,
            granularity,
        }
    }

    /// As much as finds every fault of a plan that repeats.
    pub(crate) fn short(plan: &Plan, granularity: u64) -> Run {
        let ring = plan.resources.iter().map(|r| r.copies).max().unwrap_or(1);
        Run { frames: ring + 1, remembered: 1, ..Run::full(plan, granularity) }
    }
}

/// Every tick that a frame may catch up.
fn all_ticks(plan: &Plan) -> Ticks {
    let graph = plan.graph.clone();
    Box::new(move |_, clock| graph.clock(clock).most)
}

/// Patterns of ticks: the same number in every frame, and random numbers. One where it has no clock.
pub(crate) fn rhythms(plan: &Plan) -> Vec<Ticks> {
    let most = plan.graph.clocks.iter().map(|clock| clock.most).max();
    let Some(most) = most else { return vec![all_ticks(plan)] };
    let graph = &plan.graph;
    let regular = (0..=most).map(|ticks| -> Ticks {
        let graph = graph.clone();
        Box::new(move |_, clock| graph.clock(clock).most.min(ticks))
    });
    let irregular = (0..40_u64).map(|seed| -> Ticks {
        let graph = graph.clone();
        Box::new(move |frame, clock| {
            let mut random = random(seed << 20 | u64::from(frame) << 8 | u64::from(clock.0));
            random.below(graph.clock(clock).most + 1)
        })
    });
    regular.chain(irregular).collect()
}

/// An access, or the transition of an image, that has been made.
struct Made {
    resource: usize,
    copy: u32,
    parts: u64,
    stage: Stages,
    access: AccessMask,
    store: bool,
    transition: bool,
    time: u32,
    /// Stages that wait for it, it being available if it is a store.
    waiting: Stages,
    /// Accesses that see it.
    seen_by: AccessMask,
}

/// The accesses of one step.
struct Asked {
    resource: usize,
    age: u32,
    parts: u64,
    stage: Stages,
    access: AccessMask,
    store: bool,
}

fn earlier(stages: Stages) -> Stages {
    if stages.contains(Stages::COMPUTE_SHADER) { stages | Stages::DRAW_INDIRECT } else { stages }
}

fn later(stages: Stages) -> Stages {
    if stages.contains(Stages::DRAW_INDIRECT) { stages | Stages::COMPUTE_SHADER } else { stages }
}

/// Faults in the synchronisation of a plan. Stops at the end of the frame with the first fault.
pub(crate) fn faults(plan: &Plan, run: &Run) -> Vec<String> {
    let updated = Updated::of(plan);
    let steps = asked(plan, &updated);
    // Behind the resources of the plan are the sources that only copies of them use.
    let count = updated.end;
    let planned = plan.resources.len();
    let shared = |a: usize, b: usize| a != b && a < planned && b < planned && share(plan, a, b, run.granularity);
    let neighbours: Vec<Vec<bool>> = (0..count).map(|a| (0..count).map(|b| shared(a, b)).collect()).collect();
    let mut placed: Vec<bool> =
        plan.resources.iter().map(|r| matches!(r.lifetime, Lifetime::Transient { place: Some(_), .. })).collect();
    let mut image: Vec<bool> = plan.resources.iter().map(|r| matches!(r.desc, ResourceDesc::Image(_))).collect();
    placed.resize(count, false);
    image.resize(count, false);
    let mut faults = scopes(plan);
    let mut made: Vec<Made> = Vec::new();
    let mut time = 0;
    let spans = spans(plan);
    // By clock: the number of the first tick of the frame, many from the start.
    let mut ticks = vec![1 << 20_u32; plan.graph.clocks.len()];
    for frame in 0..run.frames {
        let due: Vec<u32> = (0..ticks.len()).map(|clock| (run.ticks)(frame, ClockId(clock as u32))).collect();
        // When each image was taken into use in this frame.
        let mut active: BTreeMap<usize, u32> = BTreeMap::new();
        let mut used = vec![false; count];
        if (run.updates)(frame) {
            time += 1;
            faults.extend(update(plan, &updated, &mut made, time, frame < run.remembered));
            if !faults.is_empty() {
                return faults;
            }
        }
        for (at, step) in plan.steps.iter().enumerate() {
            time += 1;
            if let Step::Barrier(barrier) = step {
                let mut born = Vec::new();
                for activation in &barrier.activate {
                    let resource = activation.resource as usize;
                    if !placed[resource] {
                        faults.push(format!("step {at}: {resource} is discarded, but has memory of its own"));
                    }
                    if !image[resource] {
                        continue;
                    }
                    if used[resource] || active.insert(resource, time).is_some() {
                        faults.push(format!("step {at}: {resource} is discarded while it is in use"));
                    }
                    let scopes = &activation.dependency;
                    for old in made.iter().filter(|old| old.resource == resource || neighbours[resource][old.resource])
                    {
                        let waited = old.waiting.intersects(earlier(scopes.src.stages));
                        let ordered = match (old.transition, old.store) {
                            (true, _) => waited,
                            // A chain would do for Vulkan; the Khronos layer wants the access itself.
                            (false, true) => names(scopes.src, old),
                            (false, false) => waited || earlier(scopes.src.stages).intersects(old.stage),
                        };
                        if !ordered {
                            faults.push(format!(
                                "step {at}: {resource} takes over memory before {} of {} is done",
                                old.access, old.resource
                            ));
                        }
                    }
                    if frame < run.remembered {
                        born.push(Made {
                            resource,
                            copy: 0,
                            parts: u64::MAX,
                            stage: Stages::empty(),
                            access: AccessMask::empty(),
                            store: true,
                            transition: true,
                            time,
                            waiting: later(scopes.dst.stages),
                            seen_by: scopes.dst.access,
                        });
                    }
                }
                for old in &mut made {
                    pass_barrier(barrier, old);
                }
                made.extend(born);
                continue;
            }
            if let Step::Dispatch { pass } = step
                && (run.skip)(frame, *pass)
            {
                continue;
            }
            let tick = tick_of(plan, at);
            let within = |clock: usize| spans[clock].is_some_and(|(first, last)| (first..=last).contains(&at));
            if tick.is_some_and(|tick| (0..due.len()).any(|clock| within(clock) && tick >= due[clock])) {
                continue;
            }
            let mut now = Vec::new();
            for ask in &steps[at] {
                let resource = plan.resources.get(ask.resource);
                let copies = resource.map_or(1, |resource| resource.copies);
                let turns = match resource.and_then(|resource| plan.graph.resource(resource.resource).clock) {
                    None => frame + copies * 2,
                    Some(ClockId(clock)) => {
                        let clock = clock as usize;
                        let behind = spans[clock].is_none_or(|(_, last)| at > last);
                        match tick {
                            Some(tick) if within(clock) => ticks[clock] + tick,
                            _ if behind => ticks[clock] + due[clock] - 1,
                            _ => ticks[clock] - 1,
                        }
                    }
                };
                let copy = (turns - ask.age) % copies;
                used[ask.resource] = true;
                let since = if placed[ask.resource] && image[ask.resource] {
                    let Some(since) = active.get(&ask.resource) else {
                        faults.push(format!("step {at}: image {} is used before it is activated", ask.resource));
                        continue;
                    };
                    *since
                } else {
                    0
                };
                for old in &made {
                    let same = old.resource == ask.resource && old.copy == copy && old.parts & ask.parts != 0;
                    // An access before a transition is ordered before it, and the transition before this access.
                    if old.time < since
                        || !(same || neighbours[ask.resource][old.resource])
                        || !(old.store || ask.store)
                    {
                        continue;
                    }
                    let ordered =
                        if old.store { old.seen_by.contains(ask.access) } else { old.waiting.contains(ask.stage) };
                    if !ordered {
                        faults.push(format!(
                            "frame {frame}, step {at}: {} of {} is not ordered after {} of {}",
                            ask.access, ask.resource, old.access, old.resource
                        ));
                    }
                }
                if frame < run.remembered {
                    now.push(Made {
                        resource: ask.resource,
                        copy,
                        parts: ask.parts,
                        stage: ask.stage,
                        access: ask.access,
                        store: ask.store,
                        transition: false,
                        time,
                        waiting: Stages::empty(),
                        seen_by: AccessMask::empty(),
                    });
                }
            }
            made.extend(now);
            if !faults.is_empty() {
                return faults;
            }
        }
        for (ticks, due) in ticks.iter_mut().zip(&due) {
            *ticks += due;
        }
    }
    faults
}

/// The sources of a plan.
struct Updated {
    /// Their indices: those of the resources that stand for them, or one behind all resources.
    sources: BTreeMap<String, Vec<usize>>,
    /// One past the last index.
    end: usize,
}

impl Updated {
    fn of(plan: &Plan) -> Updated {
        let mut sources = BTreeMap::new();
        for (index, resource) in plan.resources.iter().enumerate() {
            if let ResourceDesc::Source(name) | ResourceDesc::SourceImage(name, _) = &resource.desc {
                sources.entry(name.clone()).or_insert_with(Vec::new).push(index);
            }
        }
        let mut end = plan.resources.len();
        for name in plan.resources.iter().filter_map(|resource| resource.copy.as_ref()) {
            sources.entry(name.clone()).or_insert_with(|| {
                end += 1;
                vec![end - 1]
            });
        }
        Updated { sources, end }
    }
}

/// Writes all of every source, between the barriers that the plan has for that.
fn update(plan: &Plan, updated: &Updated, made: &mut Vec<Made>, time: u32, remembered: bool) -> Vec<String> {
    let barrier = |memory| Barrier { memory: Some(memory), ..Barrier::default() };
    let (before, after) = (barrier(plan.updates.before), barrier(plan.updates.after));
    made.iter_mut().for_each(|old| pass_barrier(&before, old));
    let mut faults = Vec::new();
    let access = AccessMask::TRANSFER_WRITE;
    for (name, resources) in &updated.sources {
        for old in made.iter().filter(|old| resources.contains(&old.resource)) {
            let ordered = if old.store { old.seen_by.contains(access) } else { old.waiting.contains(Stages::CLEAR) };
            if !ordered {
                faults.push(format!("an update of {name} is not ordered after {} of it", old.access));
            }
        }
    }
    if remembered {
        made.extend(updated.sources.values().flatten().map(|&resource| Made {
            resource,
            copy: 0,
            parts: u64::MAX,
            stage: Stages::CLEAR,
            access,
            store: true,
            transition: false,
            time,
            waiting: Stages::empty(),
            seen_by: AccessMask::empty(),
        }));
    }
    made.iter_mut().for_each(|old| pass_barrier(&after, old));
    faults
}

fn tick_of(plan: &Plan, step: usize) -> Option<u32> {
    match plan.steps[step] {
        Step::Clear { tick, .. } => tick,
        Step::Dispatch { pass } => plan.passes[pass as usize].tick,
        _ => None,
    }
}

/// By clock: the first and last step of its ticks.
fn spans(plan: &Plan) -> Vec<Option<(usize, usize)>> {
    let graph = &plan.graph;
    let of = |step: &Step, clock: ClockId| match *step {
        Step::Clear { resource, tick } => {
            tick.is_some() && graph.resource(plan.resources[resource as usize].resource).clock == Some(clock)
        }
        Step::Dispatch { pass } => graph.pass(plan.passes[pass as usize].pass).every == Some(Every::Clock(clock)),
        _ => false,
    };
    let span = |clock| {
        let first = plan.steps.iter().position(|step| of(step, clock))?;
        Some((first, plan.steps.iter().rposition(|step| of(step, clock))?))
    };
    (0..graph.clocks.len()).map(|clock| span(ClockId(clock as u32))).collect()
}

/// Whether a source scope names an access with its stage.
fn names(scope: Scope, old: &Made) -> bool {
    scope.stages.contains(old.stage) && scope.access.contains(old.access)
}

/// Tells a remembered access about a barrier.
fn pass_barrier(barrier: &Barrier, old: &mut Made) {
    let (mut waiting, mut seen_by) = (old.waiting, old.seen_by);
    if let Some(memory) = &barrier.memory {
        let direct = if old.store {
            !old.transition && names(memory.src, old)
        } else {
            earlier(memory.src.stages).intersects(old.stage)
        };
        if direct || old.waiting.intersects(earlier(memory.src.stages)) {
            waiting |= later(memory.dst.stages);
            seen_by |= memory.dst.access;
        }
    }
    // The transition of an image orders only its own memory.
    (old.waiting, old.seen_by) = (waiting, seen_by);
}

/// An access in a scope needs its stage beside it.
fn scopes(plan: &Plan) -> Vec<String> {
    let mut faults = Vec::new();
    let of_updates = [plan.updates.before, plan.updates.after];
    let of_steps = plan.steps.iter().filter_map(|step| match step {
        Step::Barrier(barrier) => Some(barrier.memory.iter().chain(barrier.activate.iter().map(|a| &a.dependency))),
        _ => None,
    });
    for dependency in of_steps.flatten().chain(&of_updates) {
        for scope in [dependency.src, dependency.dst] {
            for access in scope.access.iter() {
                let stage = match access {
                    AccessMask::TRANSFER_WRITE | AccessMask::TRANSFER_READ => Stages::CLEAR,
                    AccessMask::INDIRECT_COMMAND_READ => Stages::DRAW_INDIRECT,
                    _ => Stages::COMPUTE_SHADER,
                };
                if !scope.stages.contains(stage) {
                    faults.push(format!("{access} without {stage}"));
                }
            }
        }
    }
    faults
}

/// The accesses of every step.
fn asked(plan: &Plan, updated: &Updated) -> Vec<Vec<Asked>> {
    let sizes = subresources(&plan.graph);
    let index: BTreeMap<ResourceId, usize> = plan.resources.iter().enumerate().map(|(i, r)| (r.resource, i)).collect();
    // The (mip, layer) pairs of random graphs fit in 64 bits.
    let set = |parts: &[(u32, u32)], layers: u32| parts.iter().fold(0_u64, |set, (m, l)| set | 1 << (m * layers + l));
    plan.steps
        .iter()
        .map(|step| match step {
            Step::Barrier(_) => Vec::new(),
            Step::Clear { resource, .. } | Step::Copy { resource } => {
                let resource = *resource as usize;
                let ask = |resource, access, store| Asked {
                    resource,
                    age: 0,
                    parts: u64::MAX,
                    stage: Stages::CLEAR,
                    access,
                    store,
                };
                let filled = matches!(step, Step::Copy { .. }).then_some(&plan.resources[resource].copy);
                let source = filled.and_then(|name| updated.sources.get(name.as_ref()?));
                let loaded = source.into_iter().flatten();
                let loaded = loaded.map(|&source| ask(source, AccessMask::TRANSFER_READ, false));
                loaded.chain([ask(resource, AccessMask::TRANSFER_WRITE, true)]).collect()
            }
            Step::Present => {
                let shown = plan.present;
                let resource = index[&shown.resource];
                let (parts, access) = match &plan.resources[resource].desc {
                    ResourceDesc::Image(image) | ResourceDesc::SourceImage(_, image) => {
                        let layer = if image.volume { 0 } else { shown.layer };
                        (set(&[(shown.mip, layer)], image.layers), AccessMask::SHADER_SAMPLED_READ)
                    }
                    _ => (1, AccessMask::SHADER_STORAGE_READ),
                };
                vec![Asked { resource, age: shown.age, parts, stage: Stages::COMPUTE_SHADER, access, store: false }]
            }
            Step::Dispatch { pass } => {
                let mut all = Vec::new();
                for bound in &plan.graph.pass(plan.passes[*pass as usize].pass).accesses {
                    let size = sizes[bound.resource.0 as usize];
                    let parts = set(&touched(bound, size), size.1);
                    let (load, store) = match bound.access {
                        Access::Read => (true, false),
                        Access::Write => (false, true),
                        Access::ReadWrite => (true, true),
                    };
                    let (stage, loads) = match bound.usage {
                        Usage::SampledImage => (Stages::COMPUTE_SHADER, AccessMask::SHADER_SAMPLED_READ),
                        Usage::StorageImage | Usage::StorageBuffer => {
                            (Stages::COMPUTE_SHADER, AccessMask::SHADER_STORAGE_READ)
                        }
                        Usage::UniformBuffer => (Stages::COMPUTE_SHADER, AccessMask::UNIFORM_READ),
                        Usage::IndirectArguments => (Stages::DRAW_INDIRECT, AccessMask::INDIRECT_COMMAND_READ),
                    };
                    let resource = index[&bound.resource];
                    let ask = |access, store| Asked { resource, age: bound.age, parts, stage, access, store };
                    if load {
                        all.push(ask(loads, false));
                    }
                    if store {
                        all.push(ask(AccessMask::SHADER_STORAGE_WRITE, true));
                    }
                }
                all
            }
        })
        .collect()
}

/// Every plan with one thing less: a barrier, the activation of an image, a stage or an access of a scope.
pub(crate) fn with_one_less(plan: &Plan) -> Vec<(String, Plan)> {
    let mut all = Vec::new();
    let mut put = |at: usize, what: String, barrier: Option<Barrier>| {
        let mut less = plan.clone();
        match barrier {
            Some(barrier) => less.steps[at] = Step::Barrier(barrier),
            // An empty barrier keeps the numbers of the steps.
            None => less.steps[at] = Step::Barrier(Barrier::default()),
        }
        all.push((format!("step {at} without {what}"), less));
    };
    for (at, step) in plan.steps.iter().enumerate() {
        let Step::Barrier(barrier) = step else { continue };
        put(at, "all".to_owned(), None);
        if let Some(memory) = barrier.memory {
            put(at, "memory".to_owned(), Some(Barrier { memory: None, ..barrier.clone() }));
            for (what, less) in smaller(memory) {
                put(at, what, Some(Barrier { memory: Some(less), ..barrier.clone() }));
            }
        }
        for (number, activation) in barrier.activate.iter().enumerate() {
            if !matches!(plan.resources[activation.resource as usize].desc, ResourceDesc::Image(_)) {
                continue;
            }
            let mut without = barrier.clone();
            without.activate.remove(number);
            put(at, format!("activation {number}"), Some(without));
            for (what, less) in smaller(activation.dependency) {
                let mut without = barrier.clone();
                without.activate[number].dependency = less;
                put(at, format!("activation {number} {what}"), Some(without));
            }
        }
    }
    all
}

/// Every plan with one thing less in what orders the updates of its sources.
pub(crate) fn with_smaller_updates(plan: &Plan) -> Vec<(String, Plan)> {
    let SourceUpdates { before, after } = plan.updates;
    let with = |what: &str, updates: SourceUpdates| (what.to_owned(), Plan { updates, ..plan.clone() });
    let less = |which: &str, dependency, put: &dyn Fn(Dependency) -> SourceUpdates| -> Vec<(String, Plan)> {
        let none = [("all".to_owned(), Dependency::default())];
        let all = none.into_iter().chain(smaller(dependency));
        all.map(|(what, less)| with(&format!("{which} {what}"), put(less))).collect()
    };
    let mut all = less("before", before, &|before| SourceUpdates { before, after });
    all.extend(less("after", after, &|after| SourceUpdates { before, after }));
    all
}

fn smaller(dependency: Dependency) -> Vec<(String, Dependency)> {
    let mut all = Vec::new();
    for source in [true, false] {
        let scope = if source { dependency.src } else { dependency.dst };
        let mut put = |what: String, scope: Scope| {
            let less =
                if source { Dependency { src: scope, ..dependency } } else { Dependency { dst: scope, ..dependency } };
            all.push((format!("{} {what}", if source { "src" } else { "dst" }), less));
        };
        for access in scope.access.iter() {
            put(access.to_string(), Scope { access: scope.access - access, ..scope });
        }
        for stage in scope.stages.iter() {
            let made = match stage {
                Stages::CLEAR => AccessMask::TRANSFER_WRITE,
                Stages::DRAW_INDIRECT => AccessMask::INDIRECT_COMMAND_READ,
                _ => !(AccessMask::TRANSFER_WRITE | AccessMask::INDIRECT_COMMAND_READ),
            };
            put(stage.to_string(), Scope { stages: scope.stages - stage, access: scope.access - made });
        }
    }
    all
}
