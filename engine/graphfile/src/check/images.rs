//! An image binding against its target: format, kind of texel, dimension, mips and layers, sampler.

use raxel_diagnostics::{Diagnostic, codes};
use raxel_graph::checked::{BoundAccess, Interval, ResourceId, Sampler, Target, Usage};
use raxel_shader::format::Format;
use raxel_shader::interface::{Access, Binding, BindingKind, Dim, ScalarKind};

use super::extents::{is_volume, mip_count};
use super::{Context, loops};
use crate::model::Mip;
use crate::resolve::Bind;

/// Checks an image binding; gives the access that it is.
pub(crate) fn check(
    context: &Context<'_>,
    index: u32,
    binding: &Binding,
    entry: &Bind,
    target: &Target,
    found: &mut Vec<Diagnostic>,
) -> Option<BoundAccess> {
    let (id, age) = entry.target.as_ref()?.value;
    // A mistake in the target itself is reported already.
    if !context.graph.resources[id.0 as usize].sound {
        return None;
    }
    texels(context, binding, entry, target, found);
    let volume = is_volume(context.graph, id);
    let layers = dimension(context, binding, entry, target, volume, found);
    mip(context, entry, id, found);
    let sampled = matches!(binding.kind, BindingKind::SampledImage { .. });
    let sampler = sampler(context, entry, target, sampled, found);
    Some(BoundAccess {
        resource: id,
        age,
        // A storage image is one mip; a sampled image is all of them unless the file names one.
        mips: match entry.mip.as_ref().map(|mip| mip.value) {
            Some(Mip::Level(mip)) => Interval::one(mip),
            Some(Mip::Round(index)) => Interval::one(index.at(0)),
            None if sampled => Interval { first: 0, count: target.mips },
            None => Interval::one(0),
        },
        layers: layers?,
        access: if sampled { Access::Read } else { binding.access },
        usage: if sampled { Usage::SampledImage } else { Usage::StorageImage },
        binding: Some(index),
        sampler,
    })
}

/// The mip is one of the target's, in every round.
fn mip(context: &Context<'_>, entry: &Bind, id: ResourceId, found: &mut Vec<Diagnostic>) {
    let Some(mip) = &entry.mip else { return };
    let limit = mip_count(context.graph, id);
    match mip.value {
        Mip::Level(level) => {
            if let Some(limit) = limit.filter(|limit| level >= *limit) {
                out_of_range(context, entry, "mip", level, limit, &mip.span, found);
            }
        }
        Mip::Round(index) => {
            let Some(repeated) = loops::around(context, index, &mip.span, found) else { return };
            let beyond = limit.and_then(|limit| Some((limit, loops::beyond(context.graph, repeated, index, limit)?)));
            if let Some((limit, (level, why))) = beyond {
                out_of_range(context, entry, "mip", level, limit, &mip.span, found);
                if let Some(error) = found.pop() {
                    found.push(error.label(repeated.count.clone(), why));
                }
            }
        }
    }
}

/// Format and kind of texel.
fn texels(context: &Context<'_>, binding: &Binding, entry: &Bind, target: &Target, found: &mut Vec<Diagnostic>) {
    let Some(bound) = &entry.target else { return };
    let declared = &context.graph.resources[bound.value.0.0 as usize];
    let (name, resource) = (&binding.name, &declared.item.name);
    let (scalar, word) = match binding.kind {
        BindingKind::StorageImage { format: Some(format), .. } if format != target.format => {
            let diagnostic = Diagnostic::error(
                codes::graph::FORMAT_MISMATCH,
                format!(
                    "`{name}` is `{}` in the shader, but target `{resource}` is `{}`",
                    format.name(),
                    target.format.name()
                ),
            )
            .label(declared.detail.clone(), format!("the format of `{resource}`"));
            let diagnostic = context.in_shader(diagnostic, binding.place.as_ref(), "the shader says");
            found.push(
                diagnostic
                    .label(bound.span.clone(), "bound here")
                    .help(format!("change one of them, e.g. `layout({}) uniform …`", target.format.name())),
            );
            return;
        }
        BindingKind::StorageImage { scalar, .. } => (scalar, "image"),
        BindingKind::SampledImage { scalar, .. } => (scalar, "sampler"),
        _ => return,
    };
    if scalar == target.format.scalar() {
        return;
    }
    let diagnostic = Diagnostic::error(
        codes::graph::TEXEL_KIND,
        format!(
            "`{name}` gives {} in the shader, but target `{resource}` holds {} (`{}`)",
            kind_name(scalar),
            kind_name(target.format.scalar()),
            target.format.name()
        ),
    )
    .label(bound.span.clone(), "bound here");
    let diagnostic = context.in_shader(diagnostic, binding.place.as_ref(), "the shader says");
    let prefix = match target.format.scalar() {
        ScalarKind::Float => "",
        ScalarKind::Int => "i",
        ScalarKind::Uint => "u",
    };
    let diagnostic = diagnostic.label(declared.detail.clone(), format!("the format of `{resource}`"));
    found.push(diagnostic.help(format!("declare `{name}` as `{prefix}{word}…`")));
}

fn kind_name(kind: ScalarKind) -> &'static str {
    match kind {
        ScalarKind::Float => "floats",
        ScalarKind::Int => "signed integers",
        ScalarKind::Uint => "unsigned integers",
    }
}

/// Dimension and layers; gives the layers that are bound.
fn dimension(
    context: &Context<'_>,
    binding: &Binding,
    entry: &Bind,
    target: &Target,
    volume: bool,
    found: &mut Vec<Diagnostic>,
) -> Option<Interval> {
    let (BindingKind::StorageImage { dim, arrayed, .. } | BindingKind::SampledImage { dim, arrayed, .. }) =
        binding.kind
    else {
        return None;
    };
    let bound = entry.target.as_ref()?;
    let resource = &context.graph.resources[bound.value.0.0 as usize].item;
    if let (true, Some(layer)) = (volume, &entry.layer) {
        found.push(
            Diagnostic::error(
                codes::graph::MIP_OR_LAYER,
                format!("target `{}` has three dimensions and no layers", resource.name),
            )
            .label(layer.span.clone(), "no such layer")
            .label(resource.place.clone(), "declared here"),
        );
        return None;
    }
    // One layer of many is a plain image; all of them are an array.
    let many = target.layers > 1 && entry.layer.is_none();
    let is = match (volume, many) {
        (true, _) => "3-D",
        (false, true) => "2-D with layers",
        (false, false) => "2-D",
    };
    let fits = match dim {
        Dim::D3 => volume && !arrayed,
        // An array of one layer is still an array, if the shader wants one.
        Dim::D2 => !volume && (arrayed || !many),
        Dim::D1 | Dim::Cube => false,
    };
    if !fits {
        let wants = match (dim, arrayed) {
            (Dim::D1, _) => "1-D",
            (Dim::D2, false) => "2-D",
            (Dim::D2, true) => "2-D with layers",
            (Dim::D3, _) => "3-D",
            (Dim::Cube, _) => "a cube",
        };
        let diagnostic = Diagnostic::error(
            codes::graph::DIMENSION,
            format!("`{}` is {wants} in the shader, but target `{}` is {is}", binding.name, resource.name),
        )
        .label(bound.span.clone(), format!("this is {is}"));
        let diagnostic = context.in_shader(diagnostic, binding.place.as_ref(), "the shader says");
        let diagnostic = diagnostic.label(resource.place.clone(), "declared here");
        found.push(match (dim, many, volume) {
            (Dim::D2, true, false) => diagnostic.help(format!(
                "bind one layer, `{{ target = \"{}\", layer = 0 }}`, or declare an array in the shader, e.g. `image2DArray`",
                resource.name
            )),
            (Dim::D3, _, false) => diagnostic.help("give the target a size of three axes, `size = [w, h, d]`"),
            (Dim::D1 | Dim::Cube, ..) => diagnostic.help("targets have two or three dimensions"),
            _ => diagnostic,
        });
        return None;
    }
    match &entry.layer {
        Some(layer) if layer.value >= target.layers => {
            out_of_range(context, entry, "layer", layer.value, target.layers, &layer.span, found);
            None
        }
        Some(layer) => Some(Interval::one(layer.value)),
        None => Some(Interval { first: 0, count: target.layers }),
    }
}

fn out_of_range(
    context: &Context<'_>,
    entry: &Bind,
    what: &str,
    value: u32,
    count: u32,
    place: &raxel_diagnostics::Span,
    found: &mut Vec<Diagnostic>,
) {
    let Some(bound) = &entry.target else { return };
    let resource = &context.graph.resources[bound.value.0.0 as usize].item;
    let s = if count == 1 { "" } else { "s" };
    found.push(
        Diagnostic::error(
            codes::graph::MIP_OR_LAYER,
            format!("target `{}` has {count} {what}{s}, so no {what} {value}", resource.name),
        )
        .label(place.clone(), format!("the last one is {}", count.saturating_sub(1)))
        .label(resource.place.clone(), "declared here"),
    );
}

/// The sampler of a sampled image: nearest and clamped by default.
fn sampler(
    context: &Context<'_>,
    entry: &Bind,
    target: &Target,
    sampled: bool,
    found: &mut Vec<Diagnostic>,
) -> Option<Sampler> {
    let linear = entry.linear.as_ref();
    let keys = [("filter", linear), ("wrap", entry.repeat.as_ref())];
    if !sampled {
        for (key, value) in keys {
            if let Some(value) = value {
                found.push(
                    Diagnostic::error(
                        codes::graph::SAMPLER,
                        format!("`{}` is a storage image, which has no `{key}`", entry.name.value),
                    )
                    .label(value.span.clone(), "only a sampled image has one"),
                );
            }
        }
        return None;
    }
    let wants_linear = linear.is_some_and(|linear| linear.value);
    if let (true, Some(linear), true) = (wants_linear, linear, target.format.scalar() != ScalarKind::Float) {
        let resource = &context.graph.resources[entry.target.as_ref()?.value.0.0 as usize];
        found.push(
            Diagnostic::error(
                codes::graph::SAMPLER,
                format!("target `{}` holds integers, which cannot be filtered", resource.item.name),
            )
            .label(linear.span.clone(), "`linear` mixes texels")
            .label(resource.detail.clone(), "an integer format")
            .help("use `filter = \"nearest\"`"),
        );
    }
    if let (true, Some(linear), Format::R32f | Format::Rg32f | Format::Rgba32f) = (wants_linear, linear, target.format)
    {
        let resource = &context.graph.resources[entry.target.as_ref()?.value.0.0 as usize];
        let message = format!("target `{}` has 32-bit floats, which not every device filters", resource.item.name);
        found.push(
            Diagnostic::warning(codes::graph::NOT_PORTABLE, message)
                .label(linear.span.clone(), "`linear` mixes texels")
                .label(resource.detail.clone(), "a format of 32-bit floats")
                .help("use a 16-bit format, or `filter = \"nearest\"`"),
        );
    }
    Some(Sampler { linear: wants_linear, repeat: entry.repeat.as_ref().is_some_and(|repeat| repeat.value) })
}
