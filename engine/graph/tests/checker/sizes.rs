//! Are sizes what they should be? Everything is counted: the texels of the world one by one, the elements of a list, and the threads
//! of a dispatch over it.

use raxel_graph::checked::*;
use raxel_graph::plan::{DeviceLimits, Plan, ResourceDesc};

use super::graphs::{Case, OUTPUT, WORLD};

/// Texels along each axis that it takes to cover the world.
pub(crate) fn of_world(scale: f64) -> [u32; 3] {
    WORLD.map(|voxels| {
        let mut texels = 1;
        while f64::from(texels) / scale < f64::from(voxels) {
            texels += 1;
        }
        texels
    })
}

/// Texels of a target's mip 0, all layers.
fn texels(target: &Target) -> u64 {
    let [w, h, d] = match target.extent {
        Extent::Output { scale: [x, y] } => {
            [(f64::from(OUTPUT[0]) * x) as u32, (f64::from(OUTPUT[1]) * y) as u32, target.layers]
        }
        Extent::Fixed2([w, h]) => [w, h, target.layers],
        Extent::Fixed3(extent) => extent,
        Extent::World { scale } => of_world(scale),
        Extent::Source | Extent::Of { .. } => [0; 3],
    };
    u64::from(w) * u64::from(h) * u64::from(d)
}

/// Elements of a buffer, where it has any.
fn elements(graph: &Graph, id: ResourceId) -> Option<u64> {
    let kind = &graph.resource(id).kind;
    let ResourceKind::Buffer(buffer) = kind else { return None };
    Some(match &buffer.size {
        BufferSize::Bytes(_) | BufferSize::Source(_) => return None,
        BufferSize::Elements { count, .. } => *count,
        BufferSize::Values(values) => values.count(),
        BufferSize::World { scale, per, .. } => {
            of_world(*scale).into_iter().map(u64::from).product::<u64>() * u64::from(*per)
        }
        BufferSize::Of { of, per, .. } => {
            let counted = match &graph.resource(*of).kind {
                ResourceKind::Target(target) => texels(target),
                ResourceKind::Buffer(_) => elements(graph, *of)?,
            };
            counted * u64::from(*per)
        }
    })
}

/// Faults in sizes and dispatches.
pub(crate) fn faults(case: &Case, plan: &Plan) -> Vec<String> {
    let graph = &case.graph;
    let mut faults = Vec::new();
    for resource in &plan.resources {
        let declared = graph.resource(resource.resource);
        match (&resource.desc, &declared.kind) {
            (ResourceDesc::Buffer(desc), ResourceKind::Buffer(buffer)) => {
                let expected = elements(graph, resource.resource).zip(buffer.size.stride());
                if let Some((count, stride)) = expected
                    && desc.size != count * u64::from(stride)
                {
                    faults.push(format!("{}: {} bytes for {count} × {stride}", declared.name, desc.size));
                }
            }
            (ResourceDesc::Image(desc), ResourceKind::Target(Target { extent: Extent::World { scale }, .. }))
                if desc.extent != of_world(*scale) || !desc.volume =>
            {
                faults.push(format!("{}: {:?} is not the world's extent", declared.name, desc.extent));
            }
            _ => {}
        }
    }
    for planned in &plan.passes {
        let pass = graph.pass(planned.pass);
        if let Dispatch::ElementsOf { buffer } = pass.dispatch {
            let threads = elements(graph, buffer).unwrap_or(0);
            let group: u64 = pass.shader.interface.local_size.iter().map(|axis| u64::from(axis.value)).product();
            let Some([x, y, z]) = planned.groups else {
                faults.push(format!("{} has no workgroups", pass.name));
                continue;
            };
            let groups = u64::from(x) * u64::from(y) * u64::from(z);
            let enough = groups * group >= threads;
            // Each row but the first exists because one less would be too long.
            let spare = groups - threads.div_ceil(group).max(1).min(groups) >= u64::from(y);
            if !enough || spare || x > DeviceLimits::PORTABLE.workgroup_count[0] {
                faults.push(format!("{}: {x}×{y}×{z} groups of {group} for {threads} threads", pass.name));
            }
        }
    }
    faults
}
