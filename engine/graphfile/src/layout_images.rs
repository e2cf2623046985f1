//! Layout images: the image of a source goes with its buffer. With `#include <raxel/world.glsl>`, neither the shader nor its graph needs to
//! know whether the layout has an image.

use raxel_diagnostics::Spanned;
use raxel_graph::checked::{ResourceId, ResourceKind};
use raxel_graph::index32;
use raxel_graph::supply::Catalog;
use raxel_shader::interface::BindingKind;

use crate::model::Mip;
use crate::reflect::Reflected;
use crate::resolve::{Bind, Declared, Resolved, supplied_image};

/// The suffix of the GLSL name of a source's block in the name of its image, `world` and `world_voxels`, and in the name by which the image
/// of a copy is written, mip 0 of it.
const SUFFIXES: [(&str, Option<u32>); 2] = [("_voxels", None), ("_texels", Some(0))];

/// Binds each image `NAME_voxels` and `NAME_texels` that a shader uses and its pass does not bind, where NAME is bound to a source with
/// an image, or to a copy of one: to the graph's target with that source, or else to a new one.
pub(crate) fn add(graph: &mut Resolved, shaders: &Reflected, sources: &dyn Catalog) {
    for (pass, shader) in shaders.iter().enumerate() {
        let bindings = shader.iter().flat_map(|shader| &shader.interface.bindings);
        let images = bindings.filter(|binding| {
            matches!(binding.kind, BindingKind::SampledImage { .. } | BindingKind::StorageImage { .. })
        });
        for name in images.map(|binding| &binding.name) {
            let binds = &graph.passes[pass].bind;
            let entry = |name: &str| binds.iter().find(|entry| entry.name.value == name);
            let suffix = SUFFIXES.iter().find_map(|(suffix, mip)| Some((name.strip_suffix(suffix)?, *mip)));
            let Some((of, mip)) = suffix else { continue };
            let block = entry(of).filter(|_| entry(name).is_none());
            let Some((block, target)) = block.and_then(|block| Some((block, block.target.clone()?))) else { continue };
            let bound = &graph.resources[target.value.0.0 as usize].item;
            let source = matches!(bound.kind, ResourceKind::Buffer(_)).then(|| bound.kind.supplied_by()).flatten();
            let origin = bound.origin.clone();
            let layout = source.and_then(|source| sources.source(source));
            let Some((source, format)) = layout.and_then(|layout| Some((layout.name.clone(), layout.image?))) else {
                continue;
            };
            let place = block.name.span.clone();
            let mip = mip.map(|mip| Spanned::new(Mip::Level(mip), place.clone()));
            let known = graph.resources.iter().position(|other| {
                let same = matches!(&other.item.kind, ResourceKind::Target(t) if t.source.as_ref() == Some(&source));
                same && other.item.origin == origin
            });
            let id = known.unwrap_or_else(|| {
                let free = free_name(name, &graph.resources);
                let source = Spanned::new(source, target.span.clone());
                graph.resources.push(supplied_image(free, &source, format, None, origin));
                graph.resources.len() - 1
            });
            graph.passes[pass].bind.push(Bind {
                name: Spanned::new(name.clone(), place),
                target: Some(Spanned::new((ResourceId(index32(id)), 0), target.span)),
                mip,
                layer: None,
                linear: None,
                repeat: None,
                partial: None,
            });
        }
    }
}

/// The name, or one made from it that no resource has.
fn free_name(name: &str, resources: &[Declared<raxel_graph::checked::Resource>]) -> String {
    let mut free = name.to_owned();
    while resources.iter().any(|resource| resource.item.name == free) {
        free.push('_');
    }
    free
}
