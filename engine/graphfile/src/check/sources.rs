//! The block of a source buffer: the shader's must be the runtime's, member by member.

use raxel_diagnostics::{Diagnostic, codes};
use raxel_graph::checked::Resource;
use raxel_graph::value::glsl;
use raxel_shader::interface::{Binding, Block, Member, Type};

use super::Context;
use crate::resolve::Declared;

/// Compares the shader's block with the layout of the source. The first member that differs is reported: differences behind it are nearly
/// always a consequence.
pub(crate) fn check(
    context: &Context<'_>,
    binding: &Binding,
    block: &Block,
    source: &str,
    declared: &Declared<Resource>,
    found: &mut Vec<Diagnostic>,
) {
    let Some(layout) = context.sources.source(source) else { return };
    let Some(difference) = difference("", &layout.block, block) else { return };
    let diagnostic = Diagnostic::error(
        codes::graph::SOURCE_LAYOUT,
        format!("the shader's block `{}` is not laid out as `{source}`: {}", block.name, difference.message),
    );
    let place = difference.place.as_ref().or(binding.place.as_ref());
    let diagnostic = context.in_shader(diagnostic, place, "the shader says");
    let help = match source.strip_prefix("world.").filter(|_| layout.collected.is_some()) {
        // A buffer that passes write has a file of its own, of the same name.
        Some(name) => format!("declare it with `#include <raxel/{name}.glsl>`"),
        None => {
            "declare it with `#include <raxel/world.glsl>`, which has the block of the layout that is bound".to_owned()
        }
    };
    found.push(diagnostic.label(declared.detail.clone(), "the source").help(help));
}

struct Difference {
    message: String,
    place: Option<raxel_diagnostics::Span>,
}

fn difference(prefix: &str, expected: &Block, actual: &Block) -> Option<Difference> {
    for (index, expected) in expected.members.iter().enumerate() {
        let name = format!("{prefix}{}", expected.name);
        let Some(actual) = actual.members.get(index) else {
            return Some(Difference { message: format!("it has no member `{name}`"), place: None });
        };
        let differs = |message| Some(Difference { message, place: actual.place.clone() });
        if actual.name != expected.name {
            return differs(format!("member {index} is `{prefix}{}`, not `{name}`", actual.name));
        }
        if actual.offset != expected.offset {
            return differs(format!("`{name}` is at offset {}, not {}", actual.offset, expected.offset));
        }
        if let Some(difference) = type_difference(&name, expected, actual) {
            return Some(difference);
        }
    }
    let more = actual.members.get(expected.members.len())?;
    let message = format!("it has one member more, `{prefix}{}`", more.name);
    Some(Difference { message, place: more.place.clone() })
}

fn type_difference(name: &str, expected: &Member, actual: &Member) -> Option<Difference> {
    let mut types = (&expected.ty, &actual.ty);
    // Arrays are compared from the outside in: length, stride, element.
    while let (
        Type::Array { element: expected, len: expected_len, stride: expected_stride },
        Type::Array { element: actual_element, len: actual_len, stride: actual_stride },
    ) = types
    {
        if expected_len != actual_len {
            break;
        }
        if expected_stride != actual_stride {
            let message = format!("elements of `{name}` are {actual_stride} bytes apart, not {expected_stride}");
            return Some(Difference { message, place: actual.place.clone() });
        }
        types = (expected, actual_element);
    }
    match types {
        (Type::Struct(expected), Type::Struct(block)) => {
            let inner = difference(&format!("{name}."), expected, block)?;
            Some(Difference { place: inner.place.or_else(|| actual.place.clone()), ..inner })
        }
        (a, b) if a == b => None,
        _ => {
            let message = format!("`{name}` is `{}`, not `{}`", glsl(&actual.ty), glsl(&expected.ty));
            Some(Difference { message, place: actual.place.clone() })
        }
    }
}
