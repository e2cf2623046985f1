//! Sizes: extents of targets, bytes of buffers and workgroup counts for one output size.

use std::collections::BTreeMap;

use crate::checked::{Buffer, BufferSize, Dispatch, Extent, Graph, Pass, ResourceId, ResourceKind, Target, Value};
use crate::plan::SourceSize;

/// Size of a resource for one output size.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Size {
    /// Of one copy of a target.
    Image {
        /// Texels of mip 0; the third is 1 unless the target is 3-D.
        extent: [u32; 3],
        /// The target is 3-D.
        volume: bool,
        /// Mips, the full chain counted out.
        mips: u32,
        /// Array layers.
        layers: u32,
    },
    /// Bytes of one copy of a buffer; `None` for a source that nobody supplies yet.
    Buffer(Option<u64>),
}

impl Size {
    /// Numbers of mips and layers that can be told apart; (1, 1) for a buffer.
    pub fn subresources(&self) -> (u32, u32) {
        match *self {
            Size::Image { mips, layers, .. } => (mips, layers),
            Size::Buffer(_) => (1, 1),
        }
    }

    /// Threads that cover one mip: texels, with depth or layers as the third axis. `None` for a buffer.
    pub fn texels(&self, mip: u32) -> Option<[u32; 3]> {
        match *self {
            Size::Image { extent, volume, layers, .. } => {
                let [w, h, d] = extent.map(|axis| axis.checked_shr(mip).unwrap_or(0).max(1));
                Some([w, h, if volume { d } else { layers }])
            }
            Size::Buffer(_) => None,
        }
    }
}

/// The sizes of all resources, in order of [`Graph::resources`].
pub fn sizes(graph: &Graph, output: [u32; 2], sources: &BTreeMap<String, SourceSize>) -> Vec<Size> {
    let mut sizes: Vec<Size> = graph
        .resources
        .iter()
        .map(|resource| match &resource.kind {
            ResourceKind::Target(target) => image(graph, target, output, sources),
            ResourceKind::Buffer(_) => Size::Buffer(None),
        })
        .collect();
    for (index, resource) in graph.resources.iter().enumerate() {
        if let ResourceKind::Buffer(buffer) = &resource.kind {
            sizes[index] = Size::Buffer(bytes(buffer, &sizes, sources));
        }
    }
    sizes
}

/// Extent of a target's mip 0 in texels, whether or not a plan creates it: what push values with `from = "target.NAME.size"`
/// show. The third axis is the depth of a 3-D target and the number of layers of any other; a buffer gives `[1, 1, 1]`.
pub fn extent(graph: &Graph, output: [u32; 2], target: ResourceId) -> [u32; 3] {
    match &graph.resource(target).kind {
        ResourceKind::Target(target) => match resolve(graph, target, output, graph.resources.len()) {
            (extent, true) => extent,
            ([width, height, _], false) => [width, height, target.layers.max(1)],
        },
        ResourceKind::Buffer(_) => [1; 3],
    }
}

fn image(graph: &Graph, target: &Target, output: [u32; 2], sources: &BTreeMap<String, SourceSize>) -> Size {
    if let Some(source) = &target.source {
        let extent = sources.get(source).and_then(|source| source.image).unwrap_or([1; 3]);
        return Size::Image { extent, volume: true, mips: full_chain(extent), layers: 1 };
    }
    let (extent, volume) = resolve(graph, target, output, graph.resources.len());
    let mips = if target.mips == 0 { full_chain(extent) } else { target.mips };
    Size::Image { extent, volume, mips, layers: target.layers.max(1) }
}

/// Number of mips down to one texel: ⌊log₂(longest axis)⌋ + 1.
pub(crate) fn full_chain(extent: [u32; 3]) -> u32 {
    let longest = extent.into_iter().max().unwrap_or(1).max(1);
    u32::BITS - longest.leading_zeros()
}

/// Extent of mip 0, and whether it is 3-D. `links` bounds the walk along `of`; a checked graph has no cycle.
fn resolve(graph: &Graph, target: &Target, output: [u32; 2], links: usize) -> ([u32; 3], bool) {
    match target.extent {
        Extent::Output { scale: [x, y] } => ([scaled(output[0], x), scaled(output[1], y), 1], false),
        Extent::Fixed2([w, h]) => ([w.max(1), h.max(1), 1], false),
        Extent::Fixed3(extent) => (extent.map(|axis| axis.max(1)), true),
        // No extent is a part of a supplier's.
        Extent::Source => ([1; 3], true),
        Extent::Of { target, scale } => match &graph.resource(target).kind {
            ResourceKind::Target(other) if links > 0 => {
                let ([w, h, d], volume) = resolve(graph, other, output, links - 1);
                ([scaled(w, scale), scaled(h, scale), if volume { scaled(d, scale) } else { 1 }], volume)
            }
            _ => ([1; 3], false),
        },
    }
}

fn scaled(axis: u32, scale: f64) -> u32 {
    // A cast from f64 saturates, and takes NaN to 0.
    ((f64::from(axis) * scale).round() as u32).max(1)
}

fn bytes(buffer: &Buffer, sizes: &[Size], sources: &BTreeMap<String, SourceSize>) -> Option<u64> {
    match &buffer.size {
        BufferSize::Bytes(bytes) => Some(*bytes),
        BufferSize::PerPixel { of, stride } => {
            let texels = sizes[of.0 as usize].texels(0).unwrap_or([1; 3]);
            Some(texels.iter().fold(u64::from(*stride), |bytes, &axis| bytes.saturating_mul(axis.into())))
        }
        BufferSize::Source(name) => sources.get(name).map(|source| source.bytes),
    }
}

/// Threads of one workgroup per axis, specialization constants applied.
pub fn local_size(pass: &Pass) -> [u32; 3] {
    pass.shader.interface.local_size.map(|axis| {
        let set = axis.spec_id.and_then(|id| pass.specialization.iter().find(|(other, _)| *other == id));
        match set {
            Some((_, Value::U32(value))) => *value,
            Some((_, Value::I32(value))) => u32::try_from(*value).unwrap_or(0),
            _ => axis.value,
        }
        .max(1)
    })
}

/// Workgroups of a pass, or `None` for an indirect dispatch.
pub fn groups(pass: &Pass, sizes: &[Size]) -> Option<[u32; 3]> {
    let threads = match pass.dispatch {
        Dispatch::ThreadsOf { target, mip } => sizes[target.0 as usize].texels(mip).unwrap_or([1; 3]),
        Dispatch::Threads(threads) => threads,
        Dispatch::Groups(groups) => return Some(groups),
        Dispatch::Indirect { .. } => return None,
    };
    let local = local_size(pass);
    Some([0, 1, 2].map(|axis| threads[axis].div_ceil(local[axis])))
}
