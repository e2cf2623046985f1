//! Sizes: extents of targets, elements and bytes of buffers, and workgroup counts for one output size and one world.

use std::collections::BTreeMap;

use crate::ir::checked::{
    Buffer, BufferSize, Dispatch, Extent, Graph, Origin, Pass, Resource, ResourceId, ResourceKind, Target, Value,
};
use crate::ir::index::index32;
use crate::ir::plan::{DeviceLimits, PlanInput, SourceSize, WorldInput, copy_name};
use crate::ir::size::{Size, constant, full_chain, product};

/// The sizes of all resources, in order of [`Graph::resources`].
pub(crate) fn sizes(graph: &Graph, input: &PlanInput<'_>) -> Vec<Size> {
    let from = From { graph, output: input.output, world: input.world.extent, sources: input.sources };
    (0..graph.resources.len()).map(|index| from.size(ResourceId(index32(index)), graph.resources.len())).collect()
}

/// The inputs of sizes.
struct From<'a> {
    graph: &'a Graph,
    output: [u32; 2],
    world: [u32; 3],
    sources: &'a BTreeMap<String, SourceSize>,
}

impl From<'_> {
    /// `links` bounds the walk along `of`; a checked graph has no cycle.
    fn size(&self, id: ResourceId, links: usize) -> Size {
        let resource = self.graph.resource(id);
        match &resource.kind {
            ResourceKind::Target(target) => self.image(resource, target, links),
            ResourceKind::Buffer(buffer) => self.buffer(resource, buffer, links),
        }
    }

    fn image(&self, resource: &Resource, target: &Target, links: usize) -> Size {
        if target.extent == Extent::Source {
            let extent = supplied(resource, self.sources).and_then(|source| source.image).unwrap_or([1; 3]);
            return Size::Image { extent, volume: true, mips: full_chain(extent), layers: 1 };
        }
        let (extent, volume) = self.extent(target, links);
        let mips = if target.mips == 0 { full_chain(extent) } else { target.mips };
        Size::Image { extent, volume, mips, layers: target.layers.max(1) }
    }

    /// Extent of mip 0, and whether it is 3-D.
    fn extent(&self, target: &Target, links: usize) -> ([u32; 3], bool) {
        match target.extent {
            Extent::Output { scale: [x, y] } => ([scaled(self.output[0], x), scaled(self.output[1], y), 1], false),
            Extent::Fixed2([w, h]) => ([w.max(1), h.max(1), 1], false),
            Extent::Fixed3(extent) => (extent.map(|axis| axis.max(1)), true),
            // No extent is a part of a supplier's.
            Extent::Source => ([1; 3], true),
            Extent::World { scale } => (self.of_world(scale), true),
            Extent::Of { target, scale } => match &self.graph.resource(target).kind {
                ResourceKind::Target(other) if links > 0 => {
                    let ([w, h, d], volume) = self.extent(other, links - 1);
                    ([scaled(w, scale), scaled(h, scale), if volume { scaled(d, scale) } else { 1 }], volume)
                }
                _ => ([1; 3], false),
            },
        }
    }

    /// A part of the world's bounds: rounded up, so that its texels cover every voxel.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "sizes are not negative and saturate; devices' limits refuse what is too large"
    )]
    fn of_world(&self, scale: f64) -> [u32; 3] {
        self.world.map(|axis| ((f64::from(axis) * scale).ceil() as u32).max(1))
    }

    fn buffer(&self, resource: &Resource, buffer: &Buffer, links: usize) -> Size {
        let elements = match &buffer.size {
            BufferSize::Bytes(bytes) => return Size::Buffer { bytes: Some(*bytes), elements: 0 },
            BufferSize::Source(_) => {
                let bytes = match &resource.origin {
                    Origin::File(contents) => Some(contents.bytes()),
                    _ => supplied(resource, self.sources).map(|source| source.bytes),
                };
                return Size::Buffer { bytes, elements: 0 };
            }
            BufferSize::Elements { count, .. } => *count,
            BufferSize::Values(values) => values.count(),
            BufferSize::World { scale, per, .. } => product(self.of_world(*scale)).saturating_mul((*per).into()),
            BufferSize::Of { of, per, .. } if links > 0 => {
                self.size(*of, links - 1).elements().saturating_mul((*per).into())
            }
            BufferSize::Of { .. } => 1,
        };
        let stride = buffer.size.stride().unwrap_or(4);
        Size::Buffer { bytes: Some(elements.saturating_mul(stride.into())), elements }
    }
}

/// The sizes of the source that supplies or fills a resource from outside, once it is there.
pub(crate) fn supplied(resource: &Resource, sources: &BTreeMap<String, SourceSize>) -> Option<SourceSize> {
    match (resource.copied_from(), resource.source()) {
        (Some(copied), _) => sources.get(&copy_name(copied)).copied(),
        (None, source) => sources.get(source?).copied(),
    }
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "sizes are not negative and saturate; devices' limits refuse what is too large"
)]
fn scaled(axis: u32, scale: f64) -> u32 {
    // A cast from f64 saturates, and takes NaN to 0.
    ((f64::from(axis) * scale).round() as u32).max(1)
}

/// The indices of the materials that a graph names. A material that the world does not have, or any without a world, is 0, which is air.
pub(crate) fn materials(graph: &Graph, world: &WorldInput<'_>) -> Vec<u32> {
    let index = |name: &str| world.materials?.iter().position(|known| known == name);
    graph.materials.iter().map(|material| index32(index(&material.name).unwrap_or(0))).collect()
}

/// The specialization constants of a pass. The front end refuses those that change from frame to frame.
pub(crate) fn specialization(pass: &Pass, sizes: &[Size], materials: &[u32]) -> Vec<(u32, Value)> {
    pass.specialization.iter().filter_map(|(id, source)| Some((*id, constant(source, sizes, materials)?))).collect()
}

/// Threads of one workgroup per axis, specialization constants applied; 0 where a constant makes it so.
pub fn local_size(pass: &Pass, specialization: &[(u32, Value)]) -> [u32; 3] {
    pass.shader.interface.local_size.map(|axis| {
        let set = axis.spec_id.and_then(|id| specialization.iter().find(|(other, _)| *other == id));
        match set {
            Some((_, Value::U32(value))) => *value,
            Some((_, Value::I32(value))) => u32::try_from(*value).unwrap_or(0),
            _ => axis.value,
        }
    })
}

/// Workgroups of a pass, or `None` for an indirect dispatch.
pub(crate) fn groups(
    pass: &Pass,
    sizes: &[Size],
    constants: &[(u32, Value)],
    world: [u32; 3],
    limits: &DeviceLimits,
) -> Option<[u32; 3]> {
    let local = local_size(pass, constants).map(|axis| axis.max(1));
    let threads = match pass.dispatch {
        Dispatch::ThreadsOf { target, mip } => sizes[target.0 as usize].texels(mip).unwrap_or([1; 3]),
        Dispatch::ThreadsOfWorld => world,
        Dispatch::GroupsOf { target, mip, tile } => {
            let texels = sizes[target.0 as usize].texels(mip).unwrap_or([1; 3]);
            return Some([0, 1, 2].map(|axis| texels[axis].div_ceil(tile[axis].max(1))));
        }
        Dispatch::ElementsOf { buffer } => {
            let threads = sizes[buffer.0 as usize].elements();
            return Some(in_rows(threads.div_ceil(product(local)), limits.workgroup_count[0]));
        }
        Dispatch::Threads(threads) => threads,
        Dispatch::Groups(groups) => return Some(groups),
        Dispatch::Indirect { .. } => return None,
    };
    Some([0, 1, 2].map(|axis| threads[axis].div_ceil(local[axis])))
}

/// `groups` workgroups in as few rows as there can be, all of one length: the limits of the device bound the rows.
/// `shaders/include/raxel/thread.glsl` counts the threads of such rows.
fn in_rows(groups: u64, longest: u32) -> [u32; 3] {
    let groups = groups.max(1);
    let rows = groups.div_ceil(u64::from(longest.max(1)));
    let saturated = |count: u64| u32::try_from(count).unwrap_or(u32::MAX);
    [saturated(groups.div_ceil(rows)), saturated(rows), 1]
}
