//! Imply: the image of a source goes with its buffer. A shader that gets its world from `#include <raxel/world.glsl>` need not know
//! whether the layout has one, and neither need its graph.

use raxel_shader::interface::BindingKind;

use crate::SourceLayout;
use crate::checked::{ResourceId, ResourceKind};
use crate::model::At;
use crate::reflect::Reflected;
use crate::resolve::{Bind, Declared, Resolved, supplied_image};

/// What follows the GLSL name of a source's block in the name of its image: `world`, `world_voxels`.
const SUFFIX: &str = "_voxels";

/// Binds each image `NAME_voxels` that a shader uses and its pass does not bind, where NAME is bound to a source with an image: to the
/// graph's target with that source, or else to a new one.
pub fn images(graph: &mut Resolved, shaders: &Reflected, sources: &[SourceLayout]) {
    for (pass, shader) in shaders.iter().enumerate() {
        let bindings = shader.iter().flat_map(|shader| &shader.interface.bindings);
        let images = bindings.filter(|binding| {
            matches!(binding.kind, BindingKind::SampledImage { .. } | BindingKind::StorageImage { .. })
        });
        for name in images.map(|binding| &binding.name) {
            let binds = &graph.passes[pass].bind;
            let entry = |name: &str| binds.iter().find(|entry| entry.name.value == name);
            let block = name.strip_suffix(SUFFIX).and_then(entry).filter(|_| entry(name).is_none());
            let Some((block, target)) = block.and_then(|block| Some((block, block.target.clone()?))) else { continue };
            let bound = &graph.resources[target.value.0.0 as usize].item;
            let source = matches!(bound.kind, ResourceKind::Buffer(_)).then(|| bound.kind.source()).flatten();
            let layout = source.and_then(|source| sources.iter().find(|layout| layout.name == source));
            let Some((source, format)) = layout.and_then(|layout| Some((layout.name.clone(), layout.image?))) else {
                continue;
            };
            let place = block.name.span.clone();
            let known = graph.resources.iter().position(|other| {
                matches!(&other.item.kind, ResourceKind::Target(target) if target.source.as_ref() == Some(&source))
            });
            let id = known.unwrap_or_else(|| {
                let free = free_name(name, &graph.resources);
                graph.resources.push(supplied_image(free, source, format, None, target.span.clone()));
                graph.resources.len() - 1
            });
            graph.passes[pass].bind.push(Bind {
                name: At::new(name.clone(), place),
                target: Some(At::new((ResourceId(id as u32), 0), target.span)),
                mip: None,
                layer: None,
                linear: None,
                repeat: None,
                partial: None,
            });
        }
    }
}

/// The name, or one made from it that no resource has.
fn free_name(name: &str, resources: &[Declared<crate::checked::Resource>]) -> String {
    let mut free = name.to_owned();
    while resources.iter().any(|resource| resource.item.name == free) {
        free.push('_');
    }
    free
}
