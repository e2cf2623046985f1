//! Order: the actions of a frame in program order, and every access that each of them makes.

use crate::checked::ResourceKind;
use crate::checked::{BoundAccess, Graph, PassId, Usage};
use crate::cull::{Cull, presented};
use crate::plan::{AccessMask, PlanInput, Stages};
use crate::region::Region;
use crate::sizes::Size;

/// A step that is no barrier.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Action {
    /// Clears this frame's copy of a resource (index among the used ones).
    Clear(u32),
    /// Dispatches a pass (index among the live ones).
    Dispatch(u32),
    /// Takes the debug target.
    Present,
}

/// One way in which one action accesses one resource.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Touch {
    /// Index into [`Order::actions`].
    pub action: u32,
    /// Index among the used resources.
    pub resource: u32,
    /// 0 is this frame's copy, n that of n frames ago.
    pub age: u32,
    /// Mips and layers.
    pub region: Region,
    /// Exactly one access.
    pub access: AccessMask,
}

impl Touch {
    /// Whether it stores.
    pub fn writes(&self) -> bool {
        is_write(self.access)
    }
}

/// Whether an access stores.
pub(crate) fn is_write(access: AccessMask) -> bool {
    (AccessMask::STORAGE_WRITE | AccessMask::TRANSFER_WRITE).contains(access)
}

/// The stage that makes an access.
pub(crate) fn stage_of(access: AccessMask) -> Stages {
    match access {
        AccessMask::INDIRECT_READ => Stages::INDIRECT,
        AccessMask::TRANSFER_WRITE => Stages::CLEAR,
        _ => Stages::COMPUTE,
    }
}

/// A frame without barriers.
#[derive(Clone, Debug, Default)]
pub(crate) struct Order {
    /// What is done, in order.
    pub actions: Vec<Action>,
    /// Every access, in order of the action.
    pub touches: Vec<Touch>,
}

/// Puts the frame in order: passes as the file has them, a clear just before the first use of what it clears, the present step
/// after the pass it is taken after.
pub(crate) fn order(graph: &Graph, sizes: &[Size], input: &PlanInput, cull: &Cull) -> Order {
    let index: Vec<Option<u32>> = {
        let mut index = vec![None; graph.resources.len()];
        for (at, resource) in cull.used.iter().enumerate() {
            index[resource.0 as usize] = Some(at as u32);
        }
        index
    };
    let mut order = Order::default();
    let mut to_clear: Vec<bool> = cull.used.iter().map(|id| graph.resource(*id).kind.is_cleared()).collect();
    let mut live = cull.live.iter().copied().enumerate().peekable();
    for at in 0..graph.passes.len() {
        if let Some((number, id)) = live.next_if(|(_, id)| id.0 as usize == at) {
            let mut touches = Vec::new();
            for access in &graph.pass(id).accesses {
                // Sources are written by nobody in a frame; the runtime replaces them between frames.
                if graph.resource(access.resource).kind.source().is_none()
                    && let Some(resource) = index[access.resource.0 as usize]
                {
                    let region = Region::of(access, &sizes[access.resource.0 as usize]);
                    touches.extend(accesses(access).map(|mask| (resource, access.age, region, mask)));
                }
            }
            order.act(Action::Dispatch(number as u32), &touches, &mut to_clear, sizes, cull);
        }
        if input.present.after == Some(PassId(at as u32)) {
            order.present(graph, sizes, input, cull, &index, &mut to_clear);
        }
    }
    if input.present.after.is_none() {
        order.present(graph, sizes, input, cull, &index, &mut to_clear);
    }
    // What only later frames read is cleared all the same.
    for (resource, _) in (0..).zip(&to_clear).filter(|(_, to_clear)| **to_clear) {
        order.clear(resource, sizes, cull);
    }
    order
}

impl Order {
    fn act(
        &mut self,
        action: Action,
        touches: &[(u32, u32, Region, AccessMask)],
        to_clear: &mut [bool],
        sizes: &[Size],
        cull: &Cull,
    ) {
        for &(resource, age, ..) in touches {
            if age == 0 && std::mem::take(&mut to_clear[resource as usize]) {
                self.clear(resource, sizes, cull);
            }
        }
        let number = self.actions.len() as u32;
        self.actions.push(action);
        for &(resource, age, region, access) in touches {
            let touch = Touch { action: number, resource, age, region, access };
            if !self.touches.ends_with(&[touch]) {
                self.touches.push(touch);
            }
        }
    }

    fn clear(&mut self, resource: u32, sizes: &[Size], cull: &Cull) {
        let region = Region::whole(&sizes[cull.used[resource as usize].0 as usize]);
        let action = self.actions.len() as u32;
        self.actions.push(Action::Clear(resource));
        self.touches.push(Touch { action, resource, age: 0, region, access: AccessMask::TRANSFER_WRITE });
    }

    fn present(
        &mut self,
        graph: &Graph,
        sizes: &[Size],
        input: &PlanInput,
        cull: &Cull,
        index: &[Option<u32>],
        to_clear: &mut [bool],
    ) {
        let present = input.present;
        let mask = match graph.resource(present.resource).kind {
            ResourceKind::Target(_) => AccessMask::SAMPLED_READ,
            ResourceKind::Buffer(_) => AccessMask::STORAGE_READ,
        };
        let touch = match index[present.resource.0 as usize] {
            Some(resource) if graph.resource(present.resource).kind.source().is_none() => {
                vec![(resource, present.age, presented(present, sizes), mask)]
            }
            _ => Vec::new(),
        };
        self.act(Action::Present, &touch, to_clear, sizes, cull);
    }
}

/// The accesses of one binding, one bit each.
fn accesses(access: &BoundAccess) -> impl Iterator<Item = AccessMask> {
    let (read, write) = match access.usage {
        Usage::SampledImage => (AccessMask::SAMPLED_READ, AccessMask::NONE),
        Usage::StorageImage | Usage::StorageBuffer => (AccessMask::STORAGE_READ, AccessMask::STORAGE_WRITE),
        Usage::UniformBuffer => (AccessMask::UNIFORM_READ, AccessMask::NONE),
        Usage::IndirectArguments => (AccessMask::INDIRECT_READ, AccessMask::NONE),
    };
    let read = access.access.reads().then_some(read);
    let write = access.access.writes().then_some(write);
    [read, write].into_iter().flatten().filter(|mask| !mask.is_empty())
}
