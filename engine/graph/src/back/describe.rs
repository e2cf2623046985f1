//! Describe: the created object of each used resource.

use raxel_shader::interface::ScalarKind;

use crate::ir::checked::{Clear, Graph, ResourceId, ResourceKind, Target, Usage};
use crate::ir::plan::{
    BufferDesc, ImageDesc, ImageUsage, Lifetime, MemoryModel, Requirements, ResourceDesc, ResourcePlan,
};
use crate::ir::size::Size;

/// Describes the used resources.
///
/// Usages come from all passes of the graph, live or not, and every target can be sampled. So another debug target or condition
/// changes neither the description of a resource nor its contents.
pub(crate) fn describe(
    graph: &Graph,
    sizes: &[Size],
    used: &[ResourceId],
    memory: &dyn MemoryModel,
) -> Vec<ResourcePlan> {
    let mut uses = vec![Uses::default(); graph.resources.len()];
    for access in graph.passes.iter().flat_map(|pass| &pass.accesses) {
        let uses = &mut uses[access.resource.0 as usize];
        uses.storage |= access.usage == Usage::StorageImage;
        uses.uniform |= access.usage == Usage::UniformBuffer;
        uses.indirect |= access.usage == Usage::IndirectArguments;
    }
    used.iter()
        .map(|&id| {
            let resource = graph.resource(id);
            let uses = uses[id.0 as usize];
            let (desc, clear, init) = match (&resource.kind, sizes[id.0 as usize]) {
                (ResourceKind::Target(target), size) => {
                    let image = image(target, size, uses);
                    let desc = match resource.source() {
                        Some(name) => ResourceDesc::SourceImage(name.to_owned(), image),
                        None => ResourceDesc::Image(image),
                    };
                    (desc, target.clear, target.init)
                }
                (ResourceKind::Buffer(buffer), size) => {
                    let size = size.bytes().unwrap_or(0);
                    let desc = match resource.source() {
                        Some(name) => ResourceDesc::Source(name.to_owned()),
                        None => {
                            ResourceDesc::Buffer(BufferDesc { size, uniform: uses.uniform, indirect: uses.indirect })
                        }
                    };
                    (desc, buffer.clear.map(pattern), buffer.init.map(pattern))
                }
            };
            let memory = match &desc {
                // Not made yet: nothing is known of it.
                ResourceDesc::SourceImage(_, image) if image.extent == [1; 3] => {
                    Requirements { size: 0, alignment: 1, type_bits: 0 }
                }
                ResourceDesc::Image(image) | ResourceDesc::SourceImage(_, image) => memory.image(image),
                ResourceDesc::Buffer(buffer) => memory.buffer(buffer),
                ResourceDesc::Source(_) => {
                    let size = sizes[id.0 as usize].bytes().unwrap_or(0);
                    Requirements { size, alignment: 1, type_bits: 0 }
                }
            };
            ResourcePlan {
                resource: id,
                init: init.unwrap_or_else(|| zero(&resource.kind)),
                desc,
                memory,
                copies: resource.history + 1,
                copy: resource.copied_from().map(str::to_owned),
                clear,
                lifetime: Lifetime::Persistent,
                varies: true,
            }
        })
        .collect()
}

#[derive(Clone, Copy, Default)]
struct Uses {
    storage: bool,
    uniform: bool,
    indirect: bool,
}

fn image(target: &Target, size: Size, uses: Uses) -> ImageDesc {
    let (extent, volume, mips, layers) = match size {
        Size::Image { extent, volume, mips, layers } => (extent, volume, mips, layers),
        Size::Buffer { .. } => ([1; 3], false, 1, 1),
    };
    let usage = ImageUsage { storage: uses.storage, sampled: true };
    ImageDesc { format: target.format, volume, extent, mips, layers, usage }
}

fn pattern(word: u32) -> Clear {
    Clear::Uint([word; 4])
}

fn zero(kind: &ResourceKind) -> Clear {
    match kind {
        ResourceKind::Target(target) => match target.format.scalar() {
            ScalarKind::Float => Clear::Float([0.0; 4]),
            ScalarKind::Int => Clear::Int([0; 4]),
            ScalarKind::Uint => Clear::Uint([0; 4]),
        },
        ResourceKind::Buffer(_) => pattern(0),
    }
}
