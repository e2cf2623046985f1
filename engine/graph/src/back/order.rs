//! Order: the actions of a frame in program order, and every access that each of them makes.

use crate::back::cull::{Cull, presented};
use crate::ir::checked::{BoundAccess, ClockId, Every, Graph, PassId, ResourceId, ResourceKind, Usage};
use crate::ir::index::index32;
use crate::ir::plan::{AccessMask, CopySelector, PlanInput, Stages};
use crate::ir::size::Size;
use crate::ir::subresources::SubresourceRange;

/// A step that is no barrier.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Action {
    /// Clears the current copy of a resource (index among the used ones), at the start of a tick if it has a clock.
    Clear(u32, Option<u32>),
    /// Fills a copy of a source (index among the used ones), in frames in which the source has changed.
    Copy(u32),
    /// Dispatches a pass (index into [`Order::passes`]).
    Dispatch(u32),
    /// Reads the debug target for display.
    Present,
}

/// An access of a range of subresources by an action, of one kind. A binding that loads and stores is two.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct ResourceAccess {
    /// Index into [`Order::actions`].
    pub action: u32,
    /// Index among the used resources.
    pub resource: u32,
    /// 0 is the current copy, n that of n frames (or ticks) ago.
    pub age: u32,
    /// Which counter selects its current copy there.
    pub selector: CopySelector,
    /// Mips and layers.
    pub range: SubresourceRange,
    /// Exactly one bit.
    pub mask: AccessMask,
}

impl ResourceAccess {
    /// Whether it stores.
    pub(crate) fn writes(&self) -> bool {
        is_write(self.mask)
    }
}

/// Whether an access stores.
pub(crate) fn is_write(access: AccessMask) -> bool {
    (AccessMask::SHADER_STORAGE_WRITE | AccessMask::TRANSFER_WRITE).contains(access)
}

/// The stage that makes an access.
pub(crate) fn stage_of(access: AccessMask) -> Stages {
    match access {
        AccessMask::INDIRECT_COMMAND_READ => Stages::DRAW_INDIRECT,
        AccessMask::TRANSFER_WRITE | AccessMask::TRANSFER_READ => Stages::CLEAR,
        _ => Stages::COMPUTE_SHADER,
    }
}

/// A frame without barriers.
#[derive(Clone, Debug, Default)]
pub(crate) struct Order {
    /// The actions, in order.
    pub actions: Vec<Action>,
    /// Every access, in order of the action.
    pub accesses: Vec<ResourceAccess>,
    /// The passes that run.
    pub passes: Vec<Instance>,
    /// By clock: its first action, and one past the last.
    pub clocks: Vec<(u32, u32)>,
}

/// A pass that runs; one of a clock is there once for each tick.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Instance {
    pub pass: PassId,
    pub tick: Option<u32>,
}

/// Puts the frame in order: passes as in the file, those of a clock once for each tick that may be due; a clear just before the first use
/// (in the frame or the tick) of its resource; the present step after its pass. `poisoned`: for each used resource whether it is filled
/// before its first use although the file does not clear it.
pub(crate) fn order(graph: &Graph, sizes: &[Size], input: &PlanInput, cull: &Cull, poisoned: &[bool]) -> Order {
    let mut index = vec![None; graph.resources.len()];
    for (at, resource) in cull.used.iter().enumerate() {
        index[resource.0 as usize] = Some(index32(at));
    }
    let clock_of = |id: &ResourceId| graph.resource(*id).clock;
    let cleared = |(at, id): (usize, &ResourceId)| {
        let filled = graph.resource(*id).kind.is_cleared() || graph.resource(*id).copied_from().is_some();
        clock_of(id).is_none() && (filled || poisoned.get(at) == Some(&true))
    };
    let mut ordering = Ordering {
        graph,
        sizes,
        input,
        cull,
        index,
        to_clear: cull.used.iter().enumerate().map(cleared).collect(),
        tick: None,
        passed: vec![false; graph.clocks.len()],
        order: Order { clocks: vec![(0, 0); graph.clocks.len()], ..Order::default() },
    };
    let mut at = 0;
    while at < graph.passes.len() {
        let first = at;
        if let Some(Every::Clock(clock)) = graph.passes[at].every {
            let of_clock = graph.passes[at..].iter().take_while(|pass| pass.every == Some(Every::Clock(clock)));
            at += of_clock.count();
            ordering.ticks(clock, first..at);
        } else {
            at += 1;
            ordering.dispatch(first);
        }
        // A present point after a pass of a clock is after all ticks of the frame.
        if input.present.after.is_some_and(|after| (first..at).contains(&(after.0 as usize))) {
            ordering.present();
        }
    }
    if input.present.after.is_none() {
        ordering.present();
    }
    // Resources that only later frames read must be cleared as well.
    ordering.clear_rest();
    ordering.order
}

/// The frame so far, and its inputs.
struct Ordering<'a> {
    graph: &'a Graph,
    sizes: &'a [Size],
    input: &'a PlanInput<'a>,
    cull: &'a Cull,
    /// By resource of the graph: its index among the used ones.
    index: Vec<Option<u32>>,
    /// By used resource: it is to be cleared, or filled as a copy, before its next use.
    to_clear: Vec<bool>,
    /// The tick that is being put in order.
    tick: Option<(ClockId, u32)>,
    /// By clock: all of its ticks in the frame have been put in order.
    passed: Vec<bool>,
    order: Order,
}

impl Ordering<'_> {
    /// Every tick of a clock that may be due, each with all of its passes in order.
    fn ticks(&mut self, clock: ClockId, passes: std::ops::Range<usize>) {
        let cleared = |id: &ResourceId| {
            let resource = self.graph.resource(*id);
            resource.clock == Some(clock) && resource.kind.is_cleared()
        };
        let cleared: Vec<bool> = self.cull.used.iter().map(cleared).collect();
        let first = index32(self.order.actions.len());
        for tick in 0..self.graph.clock(clock).most {
            self.tick = Some((clock, tick));
            let of_frame = std::mem::replace(&mut self.to_clear, cleared.clone());
            for (of_tick, of_frame) in self.to_clear.iter_mut().zip(of_frame) {
                *of_tick |= of_frame;
            }
            for pass in passes.clone() {
                self.dispatch(pass);
            }
            // Resources that are read only by passes outside of the clock.
            for resource in (0..).zip(&cleared).filter(|(_, cleared)| **cleared).map(|(resource, _)| resource) {
                if std::mem::take(&mut self.to_clear[resource as usize]) {
                    self.clear(resource);
                }
            }
        }
        self.tick = None;
        self.passed[clock.0 as usize] = true;
        self.order.clocks[clock.0 as usize] = (first, index32(self.order.actions.len()));
    }

    /// A pass of the graph, if it is live.
    fn dispatch(&mut self, pass: usize) {
        let id = PassId(index32(pass));
        if self.cull.live.binary_search(&id).is_err() {
            return;
        }
        let mut accesses = Vec::new();
        for access in &self.graph.pass(id).accesses {
            // Resources that no pass may write cause no hazards within frames: the runtime replaces their contents between frames.
            if self.graph.resource(access.resource).is_writable()
                && let Some(resource) = self.index[access.resource.0 as usize]
            {
                let range = SubresourceRange::of(access, &self.sizes[access.resource.0 as usize]);
                accesses.extend(masks(access).map(|mask| (resource, access.age, range, mask)));
            }
        }
        let number = index32(self.order.passes.len());
        self.order.passes.push(Instance { pass: id, tick: self.tick.map(|(_, tick)| tick) });
        self.act(Action::Dispatch(number), &accesses);
    }

    fn act(&mut self, action: Action, accesses: &[(u32, u32, SubresourceRange, AccessMask)]) {
        for &(resource, age, ..) in accesses {
            if age == 0 && std::mem::take(&mut self.to_clear[resource as usize]) {
                self.clear(resource);
            }
        }
        let number = index32(self.order.actions.len());
        self.order.actions.push(action);
        for &(resource, age, range, mask) in accesses {
            let selector = self.selector(resource);
            let access = ResourceAccess { action: number, resource, age, selector, range, mask };
            if !self.order.accesses.ends_with(&[access]) {
                self.order.accesses.push(access);
            }
        }
    }

    fn clear(&mut self, resource: u32) {
        let id = self.cull.used[resource as usize];
        let range = SubresourceRange::whole(&self.sizes[id.0 as usize]);
        let action = index32(self.order.actions.len());
        // The clear of a resource without a clock may come just before a pass of a tick, but belongs to no tick.
        let tick = self.graph.resource(id).clock.and(self.tick).map(|(_, tick)| tick);
        let copied = self.graph.resource(id).copied_from();
        self.order.actions.push(match copied {
            Some(_) => Action::Copy(resource),
            None => Action::Clear(resource, tick),
        });
        if let Some(copied) = copied {
            // A copy reads contents that passes may have written.
            for (from, id) in (0..).zip(&self.cull.used) {
                let source = self.graph.resource(*id);
                if source.kind.supplied_by() == Some(copied) && source.copied_from().is_none() && source.is_writable() {
                    let range = SubresourceRange::whole(&self.sizes[id.0 as usize]);
                    let (selector, mask) = (self.selector(from), AccessMask::TRANSFER_READ);
                    self.order.accesses.push(ResourceAccess { action, resource: from, age: 0, selector, range, mask });
                }
            }
        }
        let selector = self.selector(resource);
        let mask = AccessMask::TRANSFER_WRITE;
        self.order.accesses.push(ResourceAccess { action, resource, age: 0, selector, range, mask });
    }

    fn clear_rest(&mut self) {
        for resource in 0..index32(self.to_clear.len()) {
            if std::mem::take(&mut self.to_clear[resource as usize]) {
                self.clear(resource);
            }
        }
    }

    fn present(&mut self) {
        let present = self.input.present;
        let resource = self.graph.resource(present.resource);
        let mask = match resource.kind {
            ResourceKind::Target(_) => AccessMask::SHADER_SAMPLED_READ,
            ResourceKind::Buffer(_) => AccessMask::SHADER_STORAGE_READ,
        };
        let accesses = match self.index[present.resource.0 as usize] {
            Some(index) if resource.is_writable() => {
                vec![(index, present.age, presented(present, self.sizes), mask)]
            }
            _ => Vec::new(),
        };
        self.act(Action::Present, &accesses);
    }

    /// Which counter selects the current copy of a used resource at this point.
    fn selector(&self, resource: u32) -> CopySelector {
        match (self.graph.resource(self.cull.used[resource as usize]).clock, self.tick) {
            (None, _) => CopySelector::Frame,
            (Some(clock), Some((ticking, tick))) if clock == ticking => CopySelector::Tick(clock, tick),
            (Some(clock), _) if self.passed[clock.0 as usize] => CopySelector::After(clock),
            (Some(clock), _) => CopySelector::Before(clock),
        }
    }
}

/// The accesses of one binding, one bit each.
pub(crate) fn masks(access: &BoundAccess) -> impl Iterator<Item = AccessMask> {
    let (read, write) = match access.usage {
        Usage::SampledImage => (AccessMask::SHADER_SAMPLED_READ, AccessMask::empty()),
        Usage::StorageImage | Usage::StorageBuffer => {
            (AccessMask::SHADER_STORAGE_READ, AccessMask::SHADER_STORAGE_WRITE)
        }
        Usage::UniformBuffer => (AccessMask::UNIFORM_READ, AccessMask::empty()),
        Usage::IndirectArguments => (AccessMask::INDIRECT_COMMAND_READ, AccessMask::empty()),
    };
    let read = access.access.reads().then_some(read);
    let write = access.access.writes().then_some(write);
    [read, write].into_iter().flatten().filter(|mask| !mask.is_empty())
}
