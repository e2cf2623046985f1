//! Specialization constants: each that the graph sets is one of the shader's, with a value of its type.

use raxel_diagnostics::names::{closest, list};
use raxel_diagnostics::{Diagnostic, Span, Spanned, codes};
use raxel_graph::checked::ValueOrigin;
use raxel_graph::value::{ValueType, glsl};
use raxel_shader::interface::{Interface, SpecConstant, Type};

use super::{Context, loops};
use crate::literal::{describe, typed};
use crate::resolve::Feed;

/// Names of the axes of a workgroup whose constants have no other name in the shader: `layout(local_size_x_id = 0) in;`.
const WORKGROUP: [&str; 3] = ["local_size_x", "local_size_y", "local_size_z"];

/// Checks `specialization`; gives values by constant id, in order of the ids.
pub(crate) fn check(context: &Context<'_>, found: &mut Vec<Diagnostic>) -> Vec<(u32, ValueOrigin)> {
    let constants = &context.interface().specialization;
    let mut values: Vec<(u32, ValueOrigin)> = Vec::new();
    for (name, feed) in &context.pass.specialization {
        let named = constants.iter().find(|constant| constant.name == name.value && !name.value.is_empty());
        let Some(constant) = named.or_else(|| of_workgroup(context.interface(), &name.value)) else {
            let sized = || WORKGROUP.into_iter().filter(|axis| of_workgroup(context.interface(), axis).is_some());
            let named = || constants.iter().map(|constant| constant.name.as_str()).filter(|name| !name.is_empty());
            let names = || named().chain(sized());
            let diagnostic = Diagnostic::error(
                codes::graph::UNKNOWN_CONSTANT,
                format!("`{}` has no specialization constant `{}`", context.shader.request.path, name.value),
            )
            .label(name.span.clone(), "no such constant");
            found.push(match closest(&name.value, names()) {
                Some(name) => diagnostic.help(format!("did you mean `{name}`?")),
                None if names().next().is_none() => {
                    diagnostic.help("declare it, e.g. `layout(constant_id = 0) const int NAME = 1;`")
                }
                None => diagnostic.help(format!("there is {}", list(names()))),
            });
            continue;
        };
        // A value that is not known was reported before.
        let Some(feed) = feed else { continue };
        let ty = ValueType::scalar(constant.scalar);
        let is = match &feed.value {
            Feed::From(ValueOrigin::Round(index), from) if *from == ty || ty.is_i32() => {
                if loops::around(context, *index, &feed.span, found).is_some() {
                    values.push((constant.id, ValueOrigin::Round(*index)));
                }
                continue;
            }
            Feed::From(source @ (ValueOrigin::Param(_) | ValueOrigin::Builtin(_)), _) => {
                found.push(not_fixed(context, name, source, &feed.span));
                continue;
            }
            Feed::From(source, from) if *from == ty => {
                values.push((constant.id, source.clone()));
                continue;
            }
            Feed::From(_, from) => format!("`{}`", from.word()),
            Feed::Literal(literal) => match typed(literal, ty) {
                Some(value) => {
                    values.push((constant.id, ValueOrigin::Value(value)));
                    continue;
                }
                None => describe(literal),
            },
        };
        let diagnostic = Diagnostic::error(
            codes::graph::CONSTANT_TYPE,
            format!(
                "constant `{}` is `{}` in the shader, but its value is {is}",
                name.value,
                glsl(&Type::Scalar(constant.scalar)),
            ),
        )
        .label(feed.span.clone(), "");
        found.push(context.in_shader(diagnostic, constant.place.as_ref(), "the shader says"));
    }
    values.sort_by_key(|(id, _)| *id);
    values
}

/// The constant of an axis of the workgroup (`local_size_x`) that the shader sizes by id alone and gives no name.
fn of_workgroup<'i>(interface: &'i Interface, name: &str) -> Option<&'i SpecConstant> {
    let axis = WORKGROUP.iter().position(|axis| *axis == name)?;
    let id = interface.local_size[axis].spec_id?;
    interface.specialization.iter().find(|constant| constant.id == id)
}

/// A constant is built into the pipeline; a value that changes from frame to frame cannot be one.
fn not_fixed(context: &Context<'_>, name: &Spanned<String>, source: &ValueOrigin, place: &Span) -> Diagnostic {
    let what = match source {
        ValueOrigin::Param(_) => "a param",
        _ => "a value of the frame",
    };
    Diagnostic::error(
        codes::graph::CONSTANT_TYPE,
        format!("constant `{}` of pass `{}` is fed by {what}", name.value, context.pass.name.value),
    )
    .label(place.clone(), "this may change in every frame, and a constant is built into the pipeline")
    .help("take it as a push constant or in a uniform block")
}
