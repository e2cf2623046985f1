//! Updates of sources: how the writes that the runtime makes to them at the start of a frame are ordered against the plan.

use crate::back::cull::Cull;
use crate::back::order::{is_write, masks, stage_of};
use crate::ir::checked::{Graph, ResourceKind};
use crate::ir::plan::{AccessMask, Dependency, Present, Scope, SourceUpdates, Stages};

/// The dependencies of updates on the uses of sources by a plan's passes, its copies and its present step.
pub(crate) fn source_updates(graph: &Graph, cull: &Cull, present: Present) -> SourceUpdates {
    let mut used = AccessMask::empty();
    for pass in &cull.live {
        for access in &graph.pass(*pass).accesses {
            let resource = graph.resource(access.resource);
            if resource.kind.supplied_by().is_some() && resource.copied_from().is_none() {
                used |= masks(access).fold(AccessMask::empty(), |all, mask| all | mask);
            }
        }
    }
    for id in &cull.used {
        let resource = graph.resource(*id);
        if resource.copied_from().is_some() {
            used |= AccessMask::TRANSFER_READ;
        } else if *id == present.resource && resource.kind.supplied_by().is_some() {
            used |= match resource.kind {
                ResourceKind::Target(_) => AccessMask::SHADER_SAMPLED_READ,
                ResourceKind::Buffer(_) => AccessMask::SHADER_STORAGE_READ,
            };
        }
    }
    let stages = used.iter().fold(Stages::empty(), |stages, access| stages | stage_of(access));
    let written = used.iter().filter(|access| is_write(*access)).fold(AccessMask::empty(), |all, access| all | access);
    let writes = SourceUpdates::BETWEEN.src;
    SourceUpdates {
        before: Dependency {
            src: Scope { stages: stages | writes.stages, access: written | writes.access },
            dst: writes,
        },
        after: Dependency { src: writes, dst: Scope { stages, access: used } },
    }
}
