//! Inside one dispatch nothing orders one binding against another: a store through one must not be seen through another.

use raxel_diagnostics::{Diagnostic, Span, codes};
use raxel_graph::checked::{BoundAccess, Usage};

use super::Context;

/// Reports each pair of accesses of a pass that touch the same texels or bytes while one of them may write. True when there is one.
pub(crate) fn check(context: &Context<'_>, accesses: &[BoundAccess], found: &mut Vec<Diagnostic>) -> bool {
    let before = found.len();
    for (index, first) in accesses.iter().enumerate() {
        for second in &accesses[index + 1..] {
            if collide(first, second) {
                found.push(report(context, first, second));
            }
        }
    }
    found.len() > before
}

fn collide(a: &BoundAccess, b: &BoundAccess) -> bool {
    a.resource == b.resource
        && a.age == b.age
        && (a.access.writes() || b.access.writes())
        && a.mips.meets(b.mips)
        && a.layers.meets(b.layers)
}

fn report(context: &Context<'_>, a: &BoundAccess, b: &BoundAccess) -> Diagnostic {
    let resource = &context.graph.resources[a.resource.0 as usize].item;
    let mut diagnostic = Diagnostic::error(
        codes::graph::OVERLAP,
        format!(
            "pass `{}` writes `{}` through one name and sees it through another",
            context.pass.name.value, resource.name
        ),
    );
    for access in [b, a] {
        diagnostic = diagnostic.label(place(context, access), what(access));
    }
    for access in [b, a] {
        let binding = access.binding.map(|index| &context.interface().bindings[index as usize]);
        if let Some(place) = binding.and_then(|binding| binding.place.as_ref()) {
            diagnostic = diagnostic.label(place.clone(), "");
        }
    }
    let image = matches!(a.usage, Usage::StorageImage | Usage::SampledImage);
    let both = a.access.writes() && b.access.writes();
    match (image, both) {
        (true, _) => diagnostic.help(
            "bind different mips or layers, e.g. `{ target = \"…\", mip = 1 }`, declare bindings that the shader only reads as `readonly`, or read the last frame with `@1`",
        ),
        (false, true) => diagnostic.help("declare bindings that the shader only reads as `readonly`, or use one binding"),
        (false, false) => diagnostic.help("use one binding, two buffers or two passes"),
    }
}

/// The entry of `bind`, or the dispatch that reads the arguments.
fn place(context: &Context<'_>, access: &BoundAccess) -> Span {
    let name = access.binding.map(|index| &context.interface().bindings[index as usize].name);
    let entry = context.pass.bind.iter().find(|entry| Some(&entry.name.value) == name);
    let dispatch = context.pass.dispatch.as_ref().map(|dispatch| &dispatch.span);
    entry.map(|entry| &entry.name.span).or(dispatch).unwrap_or(&context.pass.name.span).clone()
}

fn what(access: &BoundAccess) -> &'static str {
    match (access.usage, access.access.writes()) {
        (Usage::IndirectArguments, _) => "its arguments are read from it",
        (_, true) => "may write it",
        (_, false) => "reads it",
    }
}
